"""The criterion for rest. An outcome is a rest_loop.OUTCOME; it counts sign changes of speeds above CREEP_RADPS."""

from __future__ import annotations

import numpy as np

WINDOW_S = 2.0  # before the end of 8 s and of 20 s after the start of the move
CREEP_RADPS = 0.02
SIGN_CHANGES = 2  # more sign changes count as oscillation
EARLY, LATE = 0, 1  # windows: the last 2 s of 8 s and of 20 s
CREEPING_SHARE = (0.015, 0.002)  # may creep in these windows


def moves(outcomes: np.ndarray, window: int) -> np.ndarray:
    """Some joint is commanded faster than at rest."""
    return (outcomes["peak_radps"][:, window] > CREEP_RADPS).any(axis=1)


def oscillates(outcomes: np.ndarray, window: int) -> np.ndarray:
    """Such a joint changes its sign more than twice."""
    fast = outcomes["peak_radps"][:, window] > CREEP_RADPS
    return (fast & (outcomes["sign_changes"][:, window] > SIGN_CHANGES)).any(axis=1)


def creeps(outcomes: np.ndarray, window: int) -> np.ndarray:
    return moves(outcomes, window) & ~oscillates(outcomes, window)
