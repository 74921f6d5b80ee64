"""Constructs a CAN FD frame bit by bit, as ISO 11898-1 defines it, with nominal bits at 1 Mbit/s and data bits at
5 Mbit/s, as a reference for the durations and loads of the simulated bus."""

from __future__ import annotations

LENGTHS = [*range(9), 12, 16, 20, 24, 32, 48, 64]
NOMINAL_NS, DATA_NS = 1000, 200


def bits(value: int, count: int) -> list[int]:
    return [value >> i & 1 for i in reversed(range(count))]


def frame_duration_ns(identifier: int, data: bytes) -> int:
    """Returns the duration from the start of frame to the end of the interframe space. Nominal and data bits have
    different durations."""
    dlc = LENGTHS.index(len(data))
    nominal = [0, *bits(identifier, 11), 0, 0, 1, 0, 1]  # SOF, id, RRS, IDE, FDF, res, BRS
    fast = [0, *bits(dlc, 4), *(bit for octet in data for bit in bits(octet, 8))]  # ESI, DLC, data
    total_ns = NOMINAL_NS * len(nominal) + DATA_NS * len(fast)
    last, run = None, 0
    for position, bit in enumerate((*nominal, *fast), 1):
        run = run + 1 if bit == last else 1
        last = bit
        if run == 5 and position < len(nominal) + len(fast):  # a stuff bit counts as the first bit of the next run
            total_ns += NOMINAL_NS if position <= len(nominal) else DATA_NS
            last, run = 1 - bit, 1
    crc_field = 4 + (17 if len(data) <= 16 else 21)  # stuff count, CRC
    fixed_stuff = len(range(0, crc_field, 4))
    total_ns += DATA_NS * (crc_field + fixed_stuff + 1)  # + 1: the CRC delimiter
    return total_ns + NOMINAL_NS * (1 + 1 + 7 + 3)  # ACK, ACK delimiter, end of frame, interframe space
