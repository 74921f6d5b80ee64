"""Decides whether an arm is at rest. `outcomes` are arrays of rest_loop.OUTCOME, which counts sign changes only between
commanded velocities faster than CREEP_RADPS."""

from __future__ import annotations

import numpy as np

WINDOW_S = 2.0  # length of the windows, which end 8 s and 20 s after the start of the move
CREEP_RADPS = 0.02
SIGN_CHANGES = 2  # more sign changes than this in a window count as oscillation
EARLY, LATE = 0, 1  # indices of the windows that end after 8 s and after 20 s
CREEPING_SHARE = (0.015, 0.002)  # share of the cases that may creep in each window


def moves(outcomes: np.ndarray, window: int) -> np.ndarray:
    """Returns, for each case, whether any joint is commanded to move faster than CREEP_RADPS."""
    return (outcomes["peak_radps"][:, window] > CREEP_RADPS).any(axis=1)


def oscillates(outcomes: np.ndarray, window: int) -> np.ndarray:
    """Returns, for each case, whether any joint is commanded to move faster than CREEP_RADPS and reverses more than
    SIGN_CHANGES times."""
    fast = outcomes["peak_radps"][:, window] > CREEP_RADPS
    return (fast & (outcomes["sign_changes"][:, window] > SIGN_CHANGES)).any(axis=1)


def creeps(outcomes: np.ndarray, window: int) -> np.ndarray:
    return moves(outcomes, window) & ~oscillates(outcomes, window)
