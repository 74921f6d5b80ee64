"""Represents CAN frames, decodes them with the DBC and checks their end-to-end protection."""

from __future__ import annotations

import binascii
import functools
from pathlib import Path
from typing import NamedTuple

import cantools
from cantools.database.can.message import Message

DBC_PATH = Path(__file__).parents[1] / "comanip.dbc"
CLASSIC = "Classic"  # prefix of the names of classic CAN frames
COUNTERS, CLASSIC_COUNTERS = 256, 16


class Frame(NamedTuple):
    """A CAN frame. t_us: time on the clock of the log or of the bus. In a remote frame only the length of `data` is
    meaningful."""

    t_us: int
    frame_id: int
    data: bytes
    fd: bool = True
    brs: bool = True  # CAN FD's bit rate switch: the data phase uses the higher rate
    esi: bool = False  # CAN FD's error state indicator: the sender is error-passive
    extended: bool = False
    remote: bool = False
    error: bool = False  # an error frame: frame_id is SocketCAN's error class
    channel: str = "vcan0"

    @property
    def message(self) -> Message | None:
        """The DBC's message with this frame's id, or None if there is none."""
        return None if self.extended or self.remote or self.error else messages().get(self.frame_id)

    @property
    def name(self) -> str:
        return self.message.name if self.message else f"0x{self.frame_id:X}"

    @property
    def counter(self) -> int:
        """The counter of the end-to-end header."""
        return self.data[1] % CLASSIC_COUNTERS if is_classic(self.name) else self.data[2]


@functools.cache
def database():
    return cantools.database.load_file(DBC_PATH)


@functools.cache
def messages() -> dict[int, Message]:
    return {message.frame_id: message for message in database().messages}


@functools.cache
def data_id(name: str) -> int | None:
    """Returns the message's E2E Data ID, or None if the message is not protected."""
    attribute = database().get_message_by_name(name).dbc.attributes.get("E2EDataId")
    return int(attribute.value) if attribute else None


def is_classic(name: str) -> bool:
    """Returns True for the name of a classic CAN frame, which is protected by E2E Profile 2."""
    return name.startswith(CLASSIC)


@functools.cache
def classic_parts(name: str) -> list[str]:
    """Returns the names of the frames that carry a CAN FD message on classic CAN. The list is empty if the message is
    the same in both profiles."""
    attributes = {message.name: message.dbc.attributes.get("PartOf") for message in database().messages}
    return [part for part, whole in attributes.items() if whole and str(whole.value) == name]


def crc(data: bytes, data_id: int) -> int:
    """Returns the CRC of AUTOSAR E2E Profile 5: CRC-16 (0x1021, initial value 0xFFFF) over the bytes after the CRC,
    followed by the Data ID, low byte first."""
    return binascii.crc_hqx(bytes(data[2:]) + data_id.to_bytes(2, "little"), 0xFFFF)


@functools.cache
def _crc8_table() -> list[int]:
    table = list(range(256))
    for _ in range(8):
        table = [(value << 1) & 0xFF ^ (0x2F if value & 0x80 else 0) for value in table]
    return table


def classic_crc(data: bytes, data_id: int) -> int:
    """Returns the CRC of AUTOSAR E2E Profile 2: CRC-8 (0x2F, initial value and final XOR 0xFF) over the bytes after the
    CRC, followed by the Data ID that belongs to the counter value: (data_id + 16 * counter) modulo 256."""
    table, value = _crc8_table(), 0xFF
    for byte in (*data[1:], (data_id + 16 * (data[1] % CLASSIC_COUNTERS)) % 256):
        value = table[value ^ byte]
    return value ^ 0xFF


def has_right_crc(frame: Frame) -> bool:
    """Returns True if the frame has an end-to-end header and its CRC is right. The frame must be a protected message of
    the DBC."""
    if len(frame.data) < (2 if is_classic(frame.name) else 3):
        return False
    if is_classic(frame.name):
        return frame.data[0] == classic_crc(frame.data, data_id(frame.name))
    return int.from_bytes(frame.data[:2], "little") == crc(frame.data, data_id(frame.name))


def protected(name: str, signals: dict, counter: int) -> bytes:
    """Returns the payload of a CAN FD message with its end-to-end header. Raises cantools' EncodeError if a signal is
    out of range."""
    message = database().get_message_by_name(name)
    data = bytearray(message.encode(signals | {"e2e_crc": 0, "e2e_counter": counter % COUNTERS}))
    data[0:2] = crc(data, data_id(name)).to_bytes(2, "little")
    return bytes(data)


def decode(frame: Frame) -> dict | None:
    """Returns the signals by name, or None if the id is not in the DBC or the frame is too short."""
    message = frame.message
    if message is None or len(frame.data) < message.length:
        return None
    return message.decode(frame.data[: message.length])


def decode_raw(frame: Frame) -> dict | None:
    """Works like decode(), but returns enumerated values as numbers."""
    message = frame.message
    if message is None or len(frame.data) < message.length:
        return None
    return message.decode(frame.data[: message.length], decode_choices=False)


def signals_text(frame: Frame) -> str:
    """Returns the signals as one line of text, without the end-to-end header."""
    signals = decode(frame)
    if signals is None:
        return frame.data.hex(" ") if frame.data else "no data"
    units = {signal.name: f" {signal.unit}" if signal.unit else "" for signal in frame.message.signals}
    return ", ".join(
        f"{name} {_short(value)}{units[name] if isinstance(value, int | float) else ''}"
        for name, value in signals.items()
        if not name.startswith("e2e_")
    )


def _short(value: object) -> str:
    return f"{value:.7g}" if isinstance(value, float) else str(value)


class Verdict(NamedTuple):
    """Result of an end-to-end check. ok: None if the frame is unprotected or not in the DBC."""

    ok: bool | None
    text: str


class E2EChecker:
    """Checks frames as a receiver does, keeping one counter per id."""

    def __init__(self):
        self._counter: dict[int, int] = {}

    def check(self, frame: Frame) -> Verdict:
        message = frame.message
        if message is None:
            return Verdict(None, "not in the DBC")
        if len(frame.data) != message.length:
            return Verdict(False, f"{len(frame.data)} bytes, expected {message.length}")
        if data_id(message.name) is None:
            return Verdict(None, "unprotected")
        if not has_right_crc(frame):
            return Verdict(False, "wrong CRC")
        counter, counters = frame.counter, CLASSIC_COUNTERS if is_classic(message.name) else COUNTERS
        step = (counter - self._counter.get(frame.frame_id, counter - 1)) % counters
        self._counter[frame.frame_id] = counter
        if step == 1:
            return Verdict(True, "ok")
        return Verdict(False, "repeated") if step == 0 else Verdict(True, f"ok, {step - 1} lost before it")
