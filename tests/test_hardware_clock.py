"""Checks how a CAN controller's timestamps are mapped to the kernel's clock. The test generates the true times itself,
so it knows the error of the mapping."""

from __future__ import annotations

import subprocess

import cffi
import numpy as np
import pytest
from c_declarations import declarations
from simulation import REPOSITORY

PERIOD_NS = 250_000  # 4,000 frames per second
START_NS = 1_700_000_000_000_000_000  # Unix time on the kernel's clock
HEADER = REPOSITORY / "hal" / "linux" / "hardware_clock.h"


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hardware_clock")
    flags = ["-std=c11", "-O1", "-fPIC", "-shared", "-fsanitize=undefined", "-fsanitize-undefined-trap-on-error"]
    subprocess.run(["gcc", *flags, HEADER.with_suffix(".c"), "-o", folder / "clock.so"], check=True)
    ffi = cffi.FFI()
    ffi.cdef(declarations([HEADER]))
    return ffi, ffi.dlopen(str(folder / "clock.so"))


def mapped(library, hardware_ns, kernel_ns) -> np.ndarray:
    ffi, lib = library
    clock = ffi.new("hardware_clock_t *")
    pairs = zip(hardware_ns, kernel_ns, strict=True)
    return np.array([lib.hardware_clock_map(clock, int(hardware), int(kernel)) for hardware, kernel in pairs])


def delays_ns(rng, count: int) -> np.ndarray:
    """Returns random interrupt delays: 20 us plus a random part of about 50 us, occasionally up to a millisecond. In
    the first 8 ms of each second, no interrupt is handled at all."""
    delays = 20_000 + rng.exponential(50_000, count)
    delays += np.where(rng.random(count) < 0.01, rng.uniform(0, 1_000_000, count), 0)
    place = np.arange(count) * PERIOD_NS % 1_000_000_000
    return np.maximum(delays, np.where(place < 8_000_000, 8_000_000 - place, 0)).astype(np.int64)


def bus(
    rng, seconds: float, ppm: float = 0.0, hardware_start_ns: int = 12_345
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns the true times of the frames on the kernel's clock, the controller's timestamps and the kernel's
    timestamps."""
    count = int(seconds * 1e9 / PERIOD_NS)
    true = START_NS + np.arange(count, dtype=np.int64) * PERIOD_NS
    hardware = hardware_start_ns + ((true - START_NS) * (1 + 1e-6 * ppm)).astype(np.int64)
    kernel = np.maximum.accumulate(true + delays_ns(rng, count))  # the kernel handles frames in order
    return true, hardware, kernel


SETTLED = 400  # frames (100 ms) until the mapping has settled


@pytest.mark.parametrize("ppm", [0, 20, 100, -100, 500, -500])
def test_jitter_is_removed_and_drift_followed(library, rng, ppm):
    """The error of the mapped times, which includes the minimum interrupt delay, is at most 0.1 ms, although the
    kernel's timestamps are up to 8 ms late."""
    true, hardware, kernel = bus(rng, 20, ppm)
    late = (mapped(library, hardware, kernel) - true)[SETTLED:]
    assert (kernel - true).max() >= 7_000_000
    assert np.percentile(kernel - true, 99) > 500_000
    assert abs(late).max() < 100_000
    assert late.std() < 0.2 * (kernel - true).std()


def test_no_frame_looks_later_than_the_kernel_saw_it(library, rng):
    _, hardware, kernel = bus(rng, 5, -300)
    hardware += rng.integers(-(10**12), 10**12, len(hardware)) * (rng.random(len(hardware)) < 0.01)  # 1 % are random
    assert (mapped(library, hardware, kernel) <= kernel).all()


@pytest.mark.parametrize("step_ns", [-(10**12), -(2**32) * 1000, -(2**56), 10**9, 3600 * 10**9])
def test_a_counter_that_wraps_or_is_set(library, rng, step_ns):
    """The mapped times are correct again within SETTLED frames after the controller's counter has stepped, as it does
    after 2^32 us or a restart of the controller."""
    true, hardware, kernel = bus(rng, 4, 50, hardware_start_ns=2**57)
    half = len(true) // 2
    hardware[half:] += step_ns
    late = mapped(library, hardware, kernel) - true
    assert (late <= kernel - true).all()
    assert abs(np.concatenate((late[SETTLED:half], late[half + SETTLED :]))).max() < 100_000


@pytest.mark.parametrize("step_ns", [10**9, -(10**9), 10**12, -(10**12)])
def test_a_kernels_clock_that_is_set(library, rng, step_ns):
    true, hardware, kernel = bus(rng, 4)
    half = len(true) // 2
    true[half:] += step_ns
    kernel[half:] += step_ns
    late = mapped(library, hardware, kernel) - true
    assert abs(np.concatenate((late[SETTLED:half], late[half + SETTLED :]))).max() < 100_000


def test_one_stamp_of_another_clock_does_no_lasting_harm(library, rng):
    """One frame gets a kernel timestamp far in the past, as may happen just while the kernel's clock is being set. The
    mapping recovers within SETTLED frames."""
    true, hardware, kernel = bus(rng, 2)
    kernel[4000] -= 10**12
    late = mapped(library, hardware, kernel) - true
    assert abs(late[4000 + SETTLED :]).max() < 100_000


def test_a_pause_of_the_bus(library, rng):
    """The mapping recovers after an hour without frames, during which the clocks have drifted apart by 0.4 s."""
    true, hardware, kernel = bus(rng, 2)
    half = len(true) // 2
    true[half:], kernel[half:] = true[half:] + 3600 * 10**9, kernel[half:] + 3600 * 10**9
    hardware[half:] += 3600 * 10**9 - 400_000_000
    late = mapped(library, hardware, kernel) - true
    assert abs(late[half + SETTLED :]).max() < 100_000
