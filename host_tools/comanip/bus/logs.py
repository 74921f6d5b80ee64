"""Reads logs of a CAN bus, frame by frame, in candump's format and in the formats that python-can reads.

candump's lines are parsed here because python-can is slower with long logs. The lines that python-can writes in
candump's format end with ` R` (received) or ` T` (transmitted).
"""

from __future__ import annotations

import gzip
import lzma
import re
import struct
from collections.abc import Iterable, Iterator
from pathlib import Path

import can

from comanip.bus.frame import Frame
from comanip.errors import ToolError

CANDUMP_SUFFIX = ".log"
PYTHON_CAN_SUFFIXES = (".asc", ".blf", ".trc")
_OPENERS = {".gz": gzip.open, ".xz": lzma.open}  # for compressed candump logs
FD_BRS, FD_ESI, FD_FDF = 1, 2, 4  # SocketCAN's flags
ERROR_FLAG = 0x20000000
ID_MASK = 0x1FFFFFFF
MICROSECONDS = 1_000_000

_LOG_LINE = re.compile(
    r"\((\d+)\.(\d{1,9})\) +(\S+) +([0-9A-F]{3}|[0-9A-F]{8})"
    r"#(?:#([0-9A-F])((?:[0-9A-F]{2})*)|R([0-8]?)|((?:[0-9A-F]{2}){0,8}))(?: [RT])?",
    re.IGNORECASE,
)
# candump's output without -L, with timestamps (-ta or -tz) or without. Two digits in brackets indicate CAN FD.
_SCREEN_LINE = re.compile(
    r" *(?:\((\d+)\.(\d{1,9})\) +)?(\S+) +([0-9A-F]{3}|[0-9A-F]{8}) +\[(\d{1,2})\]"
    r" *((?:[0-9A-F]{2} *)*|remote request)",
    re.IGNORECASE,
)


def _microseconds(seconds: str, fraction: str) -> int:
    return int(seconds) * MICROSECONDS + int(fraction[:6].ljust(6, "0"))


def _identified(identifier: str) -> tuple[int, bool, bool]:
    """Returns (id without flags, is extended, is an error frame)."""
    number = int(identifier, 16)
    error = len(identifier) == 8 and bool(number & ERROR_FLAG)
    return number & ID_MASK, len(identifier) == 8 and not error, error


def parse_candump_line(line: str) -> Frame | None:
    """Parses a line of `candump -L` or of candump's screen output. Returns None if the line is neither."""
    match = _LOG_LINE.fullmatch(line)
    if match:
        seconds, fraction, channel, identifier, flags, fd_data, remote, data = match.groups()
        t_us = _microseconds(seconds, fraction)
        number, extended, error = _identified(identifier)
        if flags is not None:
            bits = int(flags, 16)
            return Frame(
                t_us, number, bytes.fromhex(fd_data), True, bool(bits & FD_BRS), bool(bits & FD_ESI), extended,
                channel=channel,
            )  # fmt: skip
        payload = bytes(int(remote or 0)) if remote is not None else bytes.fromhex(data)
        return Frame(t_us, number, payload, False, False, False, extended, remote is not None, error, channel)
    match = _SCREEN_LINE.fullmatch(line)
    if match is None:
        return None
    seconds, fraction, channel, identifier, length, data = match.groups()
    number, extended, error = _identified(identifier)
    remote = data.startswith("remote")
    payload = bytes(int(length)) if remote else bytes.fromhex(data)
    if len(payload) != int(length):
        return None
    fd = len(length) == 2
    t_us = _microseconds(seconds, fraction) if seconds else 0
    return Frame(t_us, number, payload, fd, fd, False, extended, remote, error, channel)


def read_candump(lines: Iterable[str], name: str) -> Iterator[Frame]:
    """Yields a frame for each line. Skips empty lines. Raises ToolError for a line that is not a frame."""
    for number, line in enumerate(lines, 1):
        text = line.rstrip("\r\n ")
        if not text:
            continue
        frame = parse_candump_line(text)
        if frame is None:
            raise ToolError(
                f"{name}:{number}: '{text[:80]}' is not a frame, expected lines as `candump -L` writes them: "
                "(seconds) interface ID#DATA"
            )
        yield frame


def from_message(message: can.Message) -> Frame:
    """Converts a python-can message to a Frame."""
    data = bytes(message.dlc) if message.is_remote_frame else bytes(message.data)
    return Frame(
        round(message.timestamp * MICROSECONDS), message.arbitration_id, data, message.is_fd, message.bitrate_switch,
        message.error_state_indicator, message.is_extended_id and not message.is_error_frame, message.is_remote_frame,
        message.is_error_frame, str(message.channel if message.channel is not None else "vcan0"),
    )  # fmt: skip


def _open_text(path: Path):
    """Opens a candump log, which may be compressed."""
    opener = _OPENERS.get(path.suffix.lower(), open)
    return opener(path, mode="rt", encoding="ascii", errors="replace")


def read(path: Path) -> Iterator[Frame]:
    """Yields the frames of a log file, whose suffix determines the format. Raises ToolError if the file cannot be read
    or contains no frames."""
    is_empty = True
    for frame in _frames(path):
        is_empty = False
        yield frame
    if is_empty:
        raise ToolError(f"{path}: contains no frames: was the bus silent, or was another interface recorded?")


def _frames(path: Path) -> Iterator[Frame]:
    is_compressed = path.suffix.lower() in _OPENERS
    suffix = (path.with_suffix("") if is_compressed else path).suffix.lower()
    if is_compressed and suffix != CANDUMP_SUFFIX:
        raise ToolError(f"{path}: expected a compressed candump log, with a name that ends in .log{path.suffix}")
    if suffix not in (CANDUMP_SUFFIX, *PYTHON_CAN_SUFFIXES):
        compressed = (CANDUMP_SUFFIX + ending for ending in _OPENERS)
        known = ", ".join((CANDUMP_SUFFIX, *compressed, *PYTHON_CAN_SUFFIXES))
        raise ToolError(f"{path}: unknown log format '{suffix}', expected a name that ends in one of {known}")
    try:
        if suffix == CANDUMP_SUFFIX:
            with _open_text(path) as lines:
                yield from read_candump(lines, str(path))
        else:
            with can.LogReader(path) as reader:
                yield from map(from_message, reader)
    except (lzma.LZMAError, gzip.BadGzipFile, EOFError) as error:
        raise ToolError(f"{path}: is not a {path.suffix[1:]} file, or is damaged ({error})") from error
    except OSError as error:
        raise ToolError(f"{path}: {error.strerror or error}, expected a log of a CAN bus") from error
    except (ValueError, KeyError, IndexError, TypeError, AttributeError, struct.error, can.CanError) as error:
        raise ToolError(f"{path}: is not a {suffix} log, or is damaged ({error})") from error


def candump_line(frame: Frame) -> str:
    """Returns the frame in the format of `candump -L`."""
    identifier = (
        f"{frame.frame_id | (ERROR_FLAG if frame.error else 0):08X}"
        if frame.extended or frame.error
        else f"{frame.frame_id:03X}"
    )
    seconds, microseconds = divmod(frame.t_us, MICROSECONDS)
    if frame.remote:
        data = f"#R{len(frame.data) or ''}"
    elif frame.fd:
        data = f"##{FD_BRS * frame.brs + FD_ESI * frame.esi:X}{frame.data.hex().upper()}"
    else:
        data = f"#{frame.data.hex().upper()}"
    return f"({seconds:010d}.{microseconds:06d}) {frame.channel} {identifier}{data}"
