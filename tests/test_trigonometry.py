"""The firmware's own sine and cosine agree with numpy in double precision."""

from __future__ import annotations

import numpy as np
import pytest
from comanip._core import lib

ERROR_BOUND = 1.2e-7  # the same as in trigonometry.h


def sine_cosine(angle: float) -> tuple[float, float]:
    both = lib.sine_cosine(angle)
    return both.sine, both.cosine


def angles(rng) -> np.ndarray:
    """Returns random angles over the whole range, and angles next to the border of every octant, where the range
    reduction switches to the next octant."""
    limit = np.float32(lib.TRIGONOMETRY_MAX_RAD)
    borders = np.arange(-81, 82) * (np.pi / 4)
    near = [(borders + offset).astype(np.float32) for offset in (0, 1e-7, -1e-7, 1e-6, -1e-6, 1e-5, -1e-5)]
    steps = [np.nextafter(near[0], np.float32(direction)) for direction in (-np.inf, np.inf)]
    tiny = np.float32(10.0) ** -np.arange(1, 38, dtype=np.float32)
    points = np.concatenate([rng.uniform(-limit, limit, 200_000), *near, *steps, tiny, -tiny, [0, limit, -limit]])
    return points.astype(np.float32)[np.abs(points) <= limit]


def test_error_bound(rng):
    points = angles(rng)
    got = np.array([sine_cosine(float(x)) for x in points])
    expected = np.column_stack([np.sin(points.astype(float)), np.cos(points.astype(float))])
    assert np.abs(got - expected).max() < ERROR_BOUND


@pytest.mark.parametrize("angle", [64.00001, -64.00001, 1e9, -1e30, np.inf, -np.inf, np.nan])
def test_beyond_the_range_both_are_nan(angle):
    assert np.isnan(sine_cosine(angle)).all()
