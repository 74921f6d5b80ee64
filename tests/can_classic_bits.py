"""Constructs a classic CAN data frame bit by bit, as ISO 11898-1 defines it, as a reference for the simulated frame
durations and the computed worst cases. The CRC is crccheck's CRC-15/CAN."""

from __future__ import annotations

from can_fd_bits import bits
from crccheck.crc import Crc15

NOMINAL_NS = 1000
NOT_STUFFED = [1, 1, 1, *[1] * 7, *[1] * 3]  # CRC delimiter, ACK, ACK delimiter, end of frame, intermission


def unstuffed(identifier: int, data: bytes) -> list[int]:
    """Returns the bits from SOF to the CRC: SOF, id, RTR, IDE, FDF, DLC, data, CRC."""
    covered = [
        0,
        *bits(identifier, 11),
        0,
        0,
        0,
        *bits(len(data), 4),
        *(bit for octet in data for bit in bits(octet, 8)),
    ]
    octets = int("".join(map(str, covered)), 2).to_bytes(
        (len(covered) + 7) // 8, "big"
    )  # leading zeros do not change the CRC
    return covered + bits(Crc15.calc(octets), 15)


def stuffed(sent: list[int]) -> list[int]:
    """Inserts the complement after every five equal bits. Stuff bits count towards the next run, and a run that ends
    with the last bit is stuffed too."""
    wire, last, run = [], None, 0
    for bit in sent:
        wire.append(bit)
        last, run = bit, run + 1 if bit == last else 1
        if run == 5:
            last, run = 1 - bit, 1
            wire.append(last)
    return wire


def frame_duration_ns(identifier: int, data: bytes) -> int:
    """Returns the duration from the start of frame to the end of the intermission."""
    return NOMINAL_NS * (len(stuffed(unstuffed(identifier, data))) + len(NOT_STUFFED))
