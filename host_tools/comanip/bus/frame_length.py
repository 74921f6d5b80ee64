"""Computes the exact longest and shortest time that a CAN frame can occupy the bus, over all payloads of one length.

The number of stuff bits still to come depends on the last bit sent and on the length of the run of equal bits that ends
with it. In a classic frame the CRC is stuffed as well, so the number also depends on the CRC of the bits sent so far.
Dynamic programming over these states (10, or 10 x 32768 with the CRC) finds the largest or smallest number of stuff
bits, backwards from the last payload bit. A forward pass then finds a payload with this number of stuff bits.
Frames are those of ISO 11898-1 with 11-bit ids, from SOF to the end of the intermission, without errors.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

FD_LENGTHS = (*range(9), 12, 16, 20, 24, 32, 48, 64)  # payload bytes, indexed by DLC
STUFF_RUN = 5
CRC15_POLYNOMIAL = 0x4599
CRC15_VALUES = 1 << 15
CRC_DELIMITER_TO_INTERMISSION = 1 + 2 + 7 + 3  # CRC delimiter, ACK and its delimiter, end of frame, intermission
FD_CRC17_MAX_BYTES = 16
NS_PER_S = 1_000_000_000


@dataclass(frozen=True)
class BitRates:
    """The bit rates of a bus. data_bps: rate of CAN FD's data phase; None for classic frames."""

    nominal_bps: int
    data_bps: int | None = None

    @property
    def nominal_ns(self) -> int:
        return NS_PER_S // self.nominal_bps

    @property
    def data_ns(self) -> int:
        return NS_PER_S // (self.data_bps or self.nominal_bps)


@dataclass(frozen=True)
class FrameLength:
    """The duration of a frame, and a payload with which the frame takes that long."""

    duration_ns: int
    payload: bytes


# ---- stuffing

# State 2 * (run - 1) + bit: `bit` is the last bit sent, and `run` the number of equal bits that end with it. A stuff
# bit is counted when the next bit is sent, because in CAN FD a run that ends with the data is not followed by a stuff
# bit, but by the fixed stuff bit of the CRC field.
STATES = 2 * STUFF_RUN
START_OF_FRAME = 0  # one dominant bit


def _step(state: int, bit: int) -> tuple[int, int]:
    """Returns the state after this bit is sent, and the number of stuff bits (0 or 1) that are sent before this bit."""
    last, run = state % 2, state // 2 + 1
    stuffed = int(run == STUFF_RUN)
    if stuffed:
        last, run = 1 - last, 1
    run = run + 1 if bit == last else 1
    return 2 * (run - 1) + bit, stuffed


def _bits(value: int, count: int) -> list[int]:
    return [value >> shift & 1 for shift in reversed(range(count))]


def _crc15(crc: np.ndarray | int, bit: int) -> np.ndarray | int:
    return (crc << 1) & (CRC15_VALUES - 1) ^ CRC15_POLYNOMIAL * ((crc >> 14 & 1) ^ bit)


def _crc_stuff_bits(state: int) -> np.ndarray:
    """Returns, for each possible CRC, the number of stuff bits if that CRC is sent after this state. A stuff bit
    directly before the CRC delimiter is included."""
    crc = np.arange(CRC15_VALUES)
    states, count = np.full(CRC15_VALUES, state), np.zeros(CRC15_VALUES, np.int16)
    steps = np.array([[_step(s, bit) for bit in (0, 1)] for s in range(STATES)])
    for shift in reversed(range(15)):
        after = steps[states, crc >> shift & 1]
        states, count = after[:, 0], count + after[:, 1]
    return count + (states // 2 + 1 == STUFF_RUN)


@functools.cache
def _ahead(is_fd: bool, is_longest: bool) -> list[np.ndarray]:
    """Returns a list of arrays [state, CRC]. Element n of the list is for n remaining payload bits: it contains the
    largest or smallest number of stuff bits in these bits and, in a classic frame, in the CRC that follows. For CAN FD,
    whose CRC has fixed stuff bits, the arrays have one column."""
    extreme = np.maximum if is_longest else np.minimum
    crc = np.zeros(1, int) if is_fd else np.arange(CRC15_VALUES)
    end = [np.zeros(1, np.int16) if is_fd else _crc_stuff_bits(state) for state in range(STATES)]
    ahead = [np.array(end, np.int16)]
    crc_after = [crc if is_fd else _crc15(crc, bit) for bit in (0, 1)]
    for _ in range(8 * (FD_LENGTHS[-1] if is_fd else 8)):
        rows = []
        for state in range(STATES):
            (zero, stuff_zero), (one, stuff_one) = _step(state, 0), _step(state, 1)
            rows.append(extreme(stuff_zero + ahead[-1][zero, crc_after[0]], stuff_one + ahead[-1][one, crc_after[1]]))
        ahead.append(np.array(rows, np.int16))
    return ahead


# ---- frames


def _extreme(identifier: int, length: int, rates: BitRates, is_longest: bool) -> FrameLength:
    is_fd = rates.data_bps is not None
    if not 0 <= identifier < 1 << 11:
        raise ValueError(f"id {identifier:#x}: expected 11 bits, 0x000 to 0x7FF")
    if length not in (FD_LENGTHS if is_fd else range(9)):
        raise ValueError(
            f"length {length}: expected {'0 to 8, 12, 16, 20, 24, 32, 48 or 64' if is_fd else '0 to 8'} bytes"
        )
    # The bits after SOF: id, RRS, IDE, FDF, res, BRS | ESI, DLC in CAN FD; id, RTR, IDE, FDF, DLC in classic CAN.
    nominal = _bits(identifier, 11) + ([0, 0, 1, 0, 1] if is_fd else [0, 0, 0, *_bits(length, 4)])
    fast = [0, *_bits(FD_LENGTHS.index(length), 4)] if is_fd else []
    state, crc, stuff = START_OF_FRAME, 0, [0, 0]
    for index, bit in enumerate(nominal + fast):
        state, stuffed = _step(state, bit)
        stuff[index >= len(nominal)] += stuffed
        crc = 0 if is_fd else _crc15(crc, bit)

    ahead = _ahead(is_fd, is_longest)
    stuff[is_fd] += int(ahead[8 * length][state, crc])
    payload = 0
    for left in reversed(range(8 * length)):
        options = []
        for bit in (0, 1):
            after, stuffed = _step(state, bit)
            crc_after = 0 if is_fd else _crc15(crc, bit)
            options.append((stuffed + int(ahead[left][after, crc_after]), bit, after, crc_after))
        _, bit, state, crc = (max if is_longest else min)(options)
        payload = payload << 1 | bit

    nominal_bits = 1 + len(nominal) + stuff[0] + CRC_DELIMITER_TO_INTERMISSION
    data_bits = len(fast) + stuff[1]
    if is_fd:
        # The CRC field consists of the stuff count and the CRC, with a fixed stuff bit at its start and after every
        # fourth bit. The bit rate changes within the BRS bit and within the CRC delimiter, which together last one
        # nominal bit and one data bit.
        crc_field = 4 + (17 if length <= FD_CRC17_MAX_BYTES else 21)
        nominal_bits -= 1
        data_bits += 8 * length + crc_field + 1 + crc_field // 4 + 1
    else:
        nominal_bits += 8 * length + 15
    return FrameLength(nominal_bits * rates.nominal_ns + data_bits * rates.data_ns, payload.to_bytes(length, "big"))


@functools.cache
def longest(identifier: int, length: int, rates: BitRates) -> FrameLength:
    """Returns the longest frame with this id and number of bytes. Raises ValueError for an invalid id or length."""
    return _extreme(identifier, length, rates, True)


@functools.cache
def shortest(identifier: int, length: int, rates: BitRates) -> FrameLength:
    """Returns the shortest frame with this id and number of bytes. Raises ValueError for an invalid id or length."""
    return _extreme(identifier, length, rates, False)
