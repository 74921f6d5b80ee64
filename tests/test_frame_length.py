"""Checks frame lengths exactly: the simulated durations, and the computed longest and shortest frames, are compared
with frames that are constructed bit by bit."""

from __future__ import annotations

import re

import can_classic_bits
import can_fd_bits
import numpy as np
import pytest
from can_fd_bits import LENGTHS
from comanip.bus.frame_length import BitRates, longest, shortest
from sim_bus import lib, make_frame

FD, CLASSIC = BitRates(1_000_000, 5_000_000), BitRates(1_000_000)
DURATION_NS = {FD: can_fd_bits.frame_duration_ns, CLASSIC: can_classic_bits.frame_duration_ns}
IDENTIFIERS = [0x078, *range(0, 0x800, 61)]
RUNS = [0x00, 0xFF, 0x0F, 0xF0, 0x1F, 0xF8, 0x83, 0x7C, 0x10]


def simulated_ns(rates: BitRates, identifier: int, data: bytes) -> int:
    return lib.frame_time_ns(make_frame(identifier, data, fd=rates == FD))


def random_data(rng: np.random.Generator, length: int) -> bytes:
    """Returns random bytes, which in half of the cases have long runs of equal bits."""
    return rng.bytes(length) if rng.random() < 0.5 else bytes(rng.choice(RUNS, length).astype(np.uint8))


def lengths(rates: BitRates) -> list[int]:
    return LENGTHS if rates == FD else LENGTHS[:9]


# ---- the references themselves


def received(wire: str) -> str:
    """Returns the bits that remain after destuffing. The receiver drops the bit after five equal bits, but counts this
    bit as the first of the next run."""
    kept, run = "", ""
    for bit in wire:
        kept += "" if len(run) == 5 else bit
        run = run + bit if len(run) < 5 and run.endswith(bit) else bit
    return kept


def test_stuffing_leaves_no_run_of_six_and_can_be_undone(rng):
    for _ in range(500):
        sent = can_classic_bits.unstuffed(int(rng.integers(0x800)), random_data(rng, int(rng.integers(9))))
        text = "".join(map(str, can_classic_bits.stuffed(sent)))
        assert not re.search(r"0{6}|1{6}", text)
        assert received(text) == "".join(map(str, sent))


# ---- simulated durations


def test_10000_classic_frames_last_as_long_as_their_bits(rng):
    for i in range(10_000):
        identifier = int(rng.choice([rng.integers(0x800), 0x000, 0x7FF, 0x010, 0x07F, 0x7E0]))
        data = random_data(rng, i % 9)
        expected = can_classic_bits.frame_duration_ns(identifier, data)
        assert simulated_ns(CLASSIC, identifier, data) == expected, (hex(identifier), data.hex())


@pytest.mark.parametrize(("identifier", "length"), [(0x800, 8), (0x123, 9), (0x123, 64)])
def test_impossible_classic_frames_have_no_duration(identifier, length):
    assert lib.frame_time_ns(make_frame(identifier, bytes(length), fd=False)) < 0


# ---- extremes


@pytest.mark.parametrize("rates", [FD, CLASSIC], ids=["fd", "classic"])
@pytest.mark.parametrize("identifier", [0x000, 0x050, 0x078, 0x3E0, 0x7FF])
def test_extremes_over_all_payloads_of_one_byte(rates, identifier):
    durations = [DURATION_NS[rates](identifier, bytes([octet])) for octet in range(256)]
    assert longest(identifier, 1, rates).duration_ns == max(durations)
    assert shortest(identifier, 1, rates).duration_ns == min(durations)
    assert DURATION_NS[rates](identifier, b"") == longest(identifier, 0, rates).duration_ns


@pytest.mark.parametrize("rates", [FD, CLASSIC], ids=["fd", "classic"])
def test_extremes_over_all_payloads_of_two_bytes(rates):
    """longest() and shortest() agree with the simulator's durations (tested above) of frames with each possible payload
    of two bytes."""
    for identifier in (0x078, 0x180):
        durations = [simulated_ns(rates, identifier, value.to_bytes(2, "big")) for value in range(1 << 16)]
        assert longest(identifier, 2, rates).duration_ns == max(durations)
        assert shortest(identifier, 2, rates).duration_ns == min(durations)


@pytest.mark.parametrize("rates", [FD, CLASSIC], ids=["fd", "classic"])
def test_extremes_are_reached_and_never_exceeded(rng, rates):
    for length in lengths(rates):
        for identifier in (0x010, 0x078, int(rng.integers(0x800))):
            most, least = longest(identifier, length, rates), shortest(identifier, length, rates)
            for extreme in (most, least):
                assert len(extreme.payload) == length
                assert DURATION_NS[rates](identifier, extreme.payload) == extreme.duration_ns
                assert simulated_ns(rates, identifier, extreme.payload) == extreme.duration_ns
            for _ in range(50):
                assert (
                    least.duration_ns <= simulated_ns(rates, identifier, random_data(rng, length)) <= most.duration_ns
                )


def test_the_usual_bounds_hold_and_are_tight():
    """No frame exceeds the usual bound, and the longest frames come close to it. The bound assumes one stuff bit per
    four bits that can be stuffed; for classic frames with n bytes of data it is 55 + 10 n bits (Davis et al. 2007)."""
    for length in range(9):
        worst_us = max(longest(identifier, length, CLASSIC).duration_ns for identifier in IDENTIFIERS) / 1000
        assert 55 + 10 * length - 3 <= worst_us <= 55 + 10 * length
    usual_us = {8: 55.8, 12: 63.8, 16: 71.8, 32: 104.8, 48: 136.8, 64: 168.8}
    for length, bound_us in usual_us.items():
        worst_us = max(longest(identifier, length, FD).duration_ns for identifier in IDENTIFIERS) / 1000
        assert bound_us - 1.4 <= worst_us <= bound_us


def test_rates_scale_their_own_phase(rng):
    """Each bit rate scales only its own phase: the durations at three pairs of rates imply the same number of bits in
    the data phase."""
    for length in (8, 12, 64):
        slow = longest(0x123, length, BitRates(1_000_000, 1_000_000)).duration_ns
        fast = longest(0x123, length, FD).duration_ns
        faster = longest(0x123, length, BitRates(1_000_000, 8_000_000)).duration_ns
        data_bits = (slow - fast) // 800
        assert slow - faster == 875 * data_bits
        assert data_bits > 8 * length


@pytest.mark.parametrize(
    ("identifier", "length", "rates", "words"),
    [(0x800, 8, FD, "0x800"), (-1, 8, CLASSIC, "-0x1"), (1, 9, FD, "length 9"), (1, 12, CLASSIC, "length 12")],
)
def test_impossible_frames_are_refused(identifier, length, rates, words):
    for extreme in (longest, shortest):
        with pytest.raises(ValueError, match=words):
            extreme(identifier, length, rates)
