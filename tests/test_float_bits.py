"""Checks integer comparisons of float bit patterns against numpy's float comparisons."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from comanip._core import lib

TINY, LARGEST = np.finfo(np.float32).smallest_subnormal, np.finfo(np.float32).max
SPECIAL = [0.0, TINY, 1.1754944e-38, 1e-3, 0.99999994, 1.0, 1.0000001, 1e30, LARGEST, np.inf]


@pytest.mark.parametrize("limit", SPECIAL)
def test_below_is_less_than(limit, rng):
    """float_is_below() is correct for any number if the limit is non-negative, and for a non-negative number if the
    limit is negative."""
    random = rng.integers(0, 0x7F800000, 2000, dtype=np.uint32).view(np.float32)
    numbers = np.concatenate([np.float32(SPECIAL), random])
    for x in np.concatenate([numbers, -numbers[numbers > 0]]):
        assert lib.float_is_below(x, limit) == (x < np.float32(limit)), x
        if x > 0:
            assert not lib.float_is_below(limit, -x)


def test_minus_zero_is_below_zero():
    assert lib.float_is_below(-0.0, 0.0) and not lib.float_is_below(0.0, -0.0)


def test_the_smaller_one():
    for a, b in itertools.product(np.float32(SPECIAL), repeat=2):
        assert lib.float_smaller(a, b) == min(a, b)
