"""Tremor of the simulated hands: its spectrum, and its amplitude compared with that of recorded hands."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sim_binding import load

ffi, lib = load()

RECORDINGS = Path(__file__).resolve().parents[2] / "shared" / "data" / "hand_motion"
HANDS = ("dfki_pillow_grasp", "ethz_handheld1", "kth_ho_sample_giver", "kth_ho_sample_taker")
DEFAULT_MM = 0.1  # the default in a scenario


def sample(rms_m: float, times_s: np.ndarray, seed: int = 1, name: bytes = b"person") -> np.ndarray:
    """Returns the displacement [m], one row per time."""
    tremor, displacement_m = ffi.new("tremor_t *"), ffi.new("double[3]")
    lib.tremor_init(tremor, rms_m, seed, name)
    rows = []
    for time_s in times_s:
        lib.tremor_sample(tremor, time_s, displacement_m)
        rows.append(list(displacement_m))
    return np.array(rows)


def band_rms(displacement: np.ndarray, interval_s: float, low_hz: float, high_hz: float) -> float:
    """Returns the RMS over all axes within the frequency band, computed with a Hann window, in the unit of the
    displacement."""
    count = len(displacement)
    window = np.hanning(count)[:, None]
    power = np.abs(np.fft.rfft(displacement * window, axis=0)) ** 2
    frequency_hz = np.fft.rfftfreq(count, interval_s)
    inside = (frequency_hz >= low_hz) & (frequency_hz <= high_hz)
    return float(np.sqrt(2 * power[inside].sum() / (count * (window**2).sum())))


def test_amplitude_and_band():
    times_s = np.arange(0.5, 40.5, 0.005)
    tremor_m = sample(1e-4, times_s)
    rms_m = np.sqrt((tremor_m**2).sum(axis=1).mean())
    assert rms_m == pytest.approx(1e-4, rel=0.02)
    assert band_rms(tremor_m, 0.005, 7.9, 12.1) == pytest.approx(rms_m, rel=0.03), "there is nothing outside the band"
    np.testing.assert_allclose(np.sqrt((tremor_m**2).mean(axis=0)), 1e-4 / np.sqrt(3), rtol=0.05)


def test_it_starts_at_rest_and_is_smooth():
    """The velocity never exceeds that of 18 sines of 12 Hz in phase, and there is no jump at the start."""
    tremor_m = sample(1e-4, np.arange(0, 2, 0.001))
    largest_m = 1e-4 * np.sqrt(2 / 18) * 6
    assert np.abs(tremor_m[0]).max() == 0
    assert np.abs(tremor_m[:20]).max() < 1e-7
    assert np.abs(np.diff(tremor_m, axis=0)).max() / 0.001 < largest_m * (2 * np.pi * 12 + 1.875 / 0.5)


def test_seed_and_person_decide_it():
    times_s = np.arange(1, 2, 0.01)
    first = sample(1e-4, times_s)
    np.testing.assert_array_equal(first, sample(1e-4, times_s))
    assert not np.allclose(first, sample(1e-4, times_s, seed=2))
    assert not np.allclose(first, sample(1e-4, times_s, name=b"second"))


def rest_rms_mm(path: Path) -> np.ndarray:
    """Returns the RMS from 8 to 12 Hz, over all axes, of each stretch of 0.5 s in which the hand moves less than 10 mm.
    A cubic fit removes the slow motion. Neighbouring stretches overlap by three quarters."""
    rows = np.loadtxt(path, delimiter=",", skiprows=1)
    interval_s = np.median(np.diff(rows[:, 0]))
    count = round(0.5 / interval_s)
    x = np.linspace(-1, 1, count)
    result = []
    for first in range(0, len(rows) - count, count // 4):
        position_m = rows[first : first + count, 1:4]
        if np.linalg.norm(np.ptp(position_m, axis=0)) < 0.010:
            powers = np.vander(x, 4)
            way_m = powers @ np.linalg.lstsq(powers, position_m, rcond=None)[0]
            result.append(1e3 * band_rms(position_m - way_m, interval_s, 8, 12))
    return np.array(result)


@pytest.mark.skipif(not RECORDINGS.is_dir(), reason="the recordings are not available")
def test_default_is_within_the_range_of_recorded_hands():
    """The hands were recorded with markers, so the recorded amplitudes include the noise of the measurement."""
    rms_mm = {name: rest_rms_mm(RECORDINGS / f"{name}.csv") for name in HANDS}
    for name, values in rms_mm.items():
        low, middle, high = values.min(), np.median(values), values.max()
        print(f"{name}: {len(values)} stretches, median {middle:.3f} mm, {low:.3f} to {high:.3f}")
    assert all(len(values) > 0 for values in rms_mm.values())
    median_mm = [np.median(values) for values in rms_mm.values()]
    assert min(median_mm) <= DEFAULT_MM <= max(median_mm)
