"""Reads `candump -L` logs, which may have millions of frames, and decodes them in bulk with the DBC. The bit positions
come from cantools, not from our C code. The command `cantools decode` is too slow for such logs; test_bus_log.py tests
it on a shorter one."""

from __future__ import annotations

import re
from pathlib import Path

import cantools
import numpy as np

DBC = cantools.database.load_file(Path(__file__).parents[1] / "host_tools" / "comanip" / "comanip.dbc")
FD_MESSAGES = [message for message in DBC.messages if not message.name.startswith("Classic")]
CLASSIC_MESSAGES = [message for message in DBC.messages if message.name.startswith("Classic")]
LINE = re.compile(r"^\((\d{10}\.\d{6})\) (\w+) ([0-9A-F]{3})#(?:#1)?([0-9A-F]*)$")


class Frames:
    """All N frames of one id: their times `t_s` (N,) and their contents `data` (N, bytes), as uint8."""

    def __init__(self, message, t_s: np.ndarray, data: np.ndarray):
        self.message, self.t_s, self.data = message, t_s, data
        self._bits = np.unpackbits(data, axis=1, bitorder="little")

    def __len__(self) -> int:
        return len(self.t_s)

    def raw(self, signal: str) -> np.ndarray:
        layout = self.message.get_signal_by_name(signal)
        assert layout.byte_order == "little_endian" and layout.length < 63
        bits = self._bits[:, layout.start : layout.start + layout.length].astype(np.int64)
        value = bits @ (1 << np.arange(layout.length, dtype=np.int64))
        if layout.is_signed:
            value -= bits[:, -1] << layout.length
        return value

    def __getitem__(self, signal: str) -> np.ndarray:
        return self.raw(signal) * float(self.message.get_signal_by_name(signal).scale)


def read(path: Path) -> dict[str, Frames]:
    """Returns the frames, grouped by message name. Raises an exception on an unknown id or a line that is not in
    candump -L format."""
    times: dict[int, list[str]] = {}
    payloads: dict[int, list[str]] = {}
    last = ""
    with open(path, encoding="ascii") as lines:
        for number, line in enumerate(lines, 1):
            match = LINE.match(line)
            assert match, f"{path}:{number}: not a frame in candump -L format: {line!r}"
            assert match[1] >= last, f"{path}:{number}: time {match[1]} is earlier than the previous, {last}"
            last = match[1]
            frame_id = int(match[3], 16)
            times.setdefault(frame_id, []).append(match[1])
            payloads.setdefault(frame_id, []).append(match[4])
    frames = {}
    for frame_id, hexadecimal in payloads.items():
        message = DBC.get_message_by_frame_id(frame_id)
        data = np.frombuffer(bytes.fromhex("".join(hexadecimal)), np.uint8).reshape(len(hexadecimal), -1)
        assert data.shape[1] == message.length, f"{message.name}: {data.shape[1]} bytes, expected {message.length}"
        frames[message.name] = Frames(message, np.array(times[frame_id], float), data)
    return frames


def joint_array(frames: Frames, pattern: str, joints: int) -> np.ndarray:
    """Returns a numbered signal, e.g. "velocity_{}_radps", as an array (N, joints)."""
    return np.stack([frames[pattern.format(i)] for i in range(joints)], axis=1)
