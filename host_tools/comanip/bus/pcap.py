"""Writes logs as pcap with LINKTYPE_CAN_SOCKETCAN (227), for Wireshark and tcpdump.

Each record is SocketCAN's can_frame (16 bytes) or canfd_frame (72 bytes), except that the CAN id is in network byte
order:
https://www.tcpdump.org/linktypes/LINKTYPE_CAN_SOCKETCAN.html
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import BinaryIO

from comanip.bus.frame import Frame
from comanip.bus.logs import ERROR_FLAG, FD_BRS, FD_ESI, FD_FDF, MICROSECONDS

LINKTYPE_CAN_SOCKETCAN = 227
EXTENDED_FLAG, REMOTE_FLAG = 0x80000000, 0x40000000
_FILE_HEADER = struct.Struct("<IHHiIII")  # microseconds, version 2.4
_RECORD_HEADER = struct.Struct("<IIII")
_CAN_FRAME = struct.Struct(">IBxxx8s")
_CANFD_FRAME = struct.Struct(">IBBxx64s")


def packet(frame: Frame) -> bytes:
    identifier = frame.frame_id | EXTENDED_FLAG * frame.extended | REMOTE_FLAG * frame.remote | ERROR_FLAG * frame.error
    if frame.fd:
        flags = FD_FDF | FD_BRS * frame.brs | FD_ESI * frame.esi
        return _CANFD_FRAME.pack(identifier, len(frame.data), flags, frame.data)
    return _CAN_FRAME.pack(identifier, len(frame.data), frame.data)


def write(file: BinaryIO, frames: Iterable[Frame]) -> int:
    """Writes the frames and returns their number."""
    file.write(_FILE_HEADER.pack(0xA1B2C3D4, 2, 4, 0, 0, _CANFD_FRAME.size, LINKTYPE_CAN_SOCKETCAN))
    count = 0
    for frame in frames:
        record = packet(frame)
        seconds, microseconds = divmod(frame.t_us, MICROSECONDS)
        file.write(_RECORD_HEADER.pack(seconds, microseconds, len(record), len(record)) + record)
        count += 1
    return count
