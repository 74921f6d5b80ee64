"""Computes error, delay and noise of the end effector's path relative to its target path. Paths are (T, 3) in m, with
one row per tick of 1 ms."""

from __future__ import annotations

import numpy as np

TICK_S = 1e-3
DELAYS = range(-40, 201)  # candidate delays in ms
COARSE_MS = 5  # the coarse search tries every fifth delay and compares every fifth tick


def errors_mm(path_m: np.ndarray, truth_m: np.ndarray) -> np.ndarray:
    """Returns the distances between the paths (T,)."""
    return 1e3 * np.linalg.norm(path_m - truth_m, axis=1)


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def delay_ms(path_m: np.ndarray, truth_m: np.ndarray) -> float:
    """Returns the delay by which truth_m must be shifted to fit path_m best in the least-squares sense, apart from a
    constant offset. Interpolates between ticks with a parabola through the best delay and its two neighbours. Returns
    NaN if the paths are too short, if the target did not move, or if the best delay is at an end of the search
    range."""
    reach = max(abs(DELAYS.start), DELAYS.stop)
    begin, end = reach, len(path_m) - reach
    if end - begin < reach or np.ptp(truth_m, axis=0).max() < 1e-4:
        return float("nan")

    def cost(shift: int, stride: int) -> float:
        difference = path_m[begin:end:stride] - truth_m[begin - shift : end - shift : stride]
        return float(np.mean(np.sum(np.square(difference - difference.mean(axis=0)), axis=1)))

    coarse = min(DELAYS[::COARSE_MS], key=lambda shift: cost(shift, COARSE_MS))
    near = range(max(DELAYS.start, coarse - COARSE_MS), min(DELAYS.stop, coarse + COARSE_MS + 1))
    best = min(near, key=lambda shift: cost(shift, 1))
    if best in (DELAYS.start, DELAYS.stop - 1):
        return float("nan")
    before, least, after = (cost(best + step, 1) for step in (-1, 0, 1))
    curvature = before - 2.0 * least + after
    return best + (0.5 * (before - after) / curvature if curvature > 0.0 else 0.0)


def acceleration_rms_mps2(path_m: np.ndarray) -> float:
    """Returns the RMS magnitude of the acceleration, computed from second differences over single ticks."""
    return rms(np.linalg.norm(np.diff(path_m, 2, axis=0), axis=1) / TICK_S**2)


def noise_um(path_m: np.ndarray) -> float:
    """Returns the RMS distance from the mean position, for an end effector that should be at rest."""
    return 1e6 * rms(np.linalg.norm(path_m - path_m.mean(axis=0), axis=1))


def limit_share(command_radps: np.ndarray, velocity_max_radps: np.ndarray, acceleration_max_radps2: float) -> float:
    """Returns the share of ticks in which a joint is commanded at its limit of speed or acceleration. command_radps:
    (T, n), with a resolution of 1 mrad/s."""
    step_radps = 1e-3  # resolution of the commands on the bus
    change = np.abs(np.diff(command_radps, axis=0)).max(axis=1)
    at_acceleration = change > acceleration_max_radps2 * TICK_S - 0.5 * step_radps
    at_speed = (np.abs(command_radps[1:]) > velocity_max_radps - 1.5 * step_radps).any(axis=1)
    return float(np.mean(at_acceleration | at_speed))
