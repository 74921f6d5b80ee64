"""Checks SLCAN against independent code: python-can's slcan bus on a stand-in serial port, and a grammar of the dialect
for CAN FD."""

from __future__ import annotations

import re
from queue import SimpleQueue

import can
from can.interfaces.slcan import slcanBus
from can.util import CAN_FD_DLC


class _Port:
    write_timeout = None

    def __init__(self) -> None:
        self.written = b""

    def write(self, data: bytes) -> None:
        self.written += data

    def flush(self) -> None:
        pass


class StockSlcan(slcanBus):
    """python-can's slcan bus, on a stand-in serial port that only stores the bytes."""

    def __init__(self) -> None:
        self.serialPortOrig = _Port()
        self._queue: SimpleQueue[str] = SimpleQueue()
        self._is_shutdown = True

    def line(self, message: can.Message) -> bytes:
        self.serialPortOrig.written = b""
        self.send(message)
        return self.serialPortOrig.written

    def message(self, line: bytes) -> can.Message | None:
        self._queue.put(line.decode())
        return self._recv_internal(0)[0]


# Patterns of a data length code followed by the hex digits of that many data bytes.
_FIELDS = "|".join(f"{code:X}[0-9A-F]{{{2 * CAN_FD_DLC[code]}}}" for code in range(16))
_CLASSIC_FIELDS = "|".join(f"{code:X}[0-9A-F]{{{2 * code}}}" for code in range(9))
FRAME = re.compile(rf"(t[0-7][0-9A-F]{{2}}({_CLASSIC_FIELDS})|[db][0-7][0-9A-F]{{2}}({_FIELDS}))\Z", re.IGNORECASE)
NOT_OF_THIS_BUS = "TDBrROCLSsYyMmAEFVvNZz"


def read(stream: bytes) -> tuple[list[tuple[int, bytes]], int]:
    """Returns the frames (id, data) in a stream of lines, and the number of malformed lines. An unfinished last line
    does not count."""
    frames, malformed = [], 0
    for raw in stream.split(b"\r")[:-1]:
        line = raw.lstrip(b"\a").decode("latin-1")
        if line[:1] in ("t", "d", "b") and line.isascii() and FRAME.match(line):
            frames.append((int(line[1:4], 16), bytes.fromhex(line[5:])))
        elif line != "" and line[0] not in NOT_OF_THIS_BUS:
            malformed += 1
    return frames, malformed
