"""Filters a follower's input with the One-Euro filter (Casiez, Roussel, Vogel, "1 Euro Filter: A Simple Speed-based
Low-pass Filter for Noisy Input in Interactive Systems", CHI 2012). Positions are filtered per axis. Rotations are
filtered along the great circle, with a cutoff that depends on the angular speed."""

from __future__ import annotations

import dataclasses

import numpy as np

from comanip_dev.following import rotations
from comanip_dev.following.tracker import Samples

DERIVATIVE_CUTOFF_HZ = 1.0  # from the paper


def _share(cutoff_hz: np.ndarray | float, period_s: float) -> np.ndarray | float:
    """Returns the weight of the new sample in a low-pass filter with this cutoff."""
    return 1.0 / (1.0 + 1.0 / (2.0 * np.pi * cutoff_hz * period_s))


def filtered(samples: Samples, min_cutoff_hz: float, beta_per_m: float) -> Samples:
    """Filters the valid samples. beta_per_m: increase of the cutoff in Hz per m/s or rad/s of the hand's speed."""
    position_m, rotation = samples.position_m.copy(), samples.rotation.copy()
    seen = np.flatnonzero(samples.valid)
    speed_mps, turning_radps = np.zeros(3), np.zeros(3)
    for last, row in zip(seen[:-1], seen[1:]):
        period_s = 1e-6 * float(samples.measured_us[row] - samples.measured_us[last])
        slow = _share(DERIVATIVE_CUTOFF_HZ, period_s)
        speed_mps += slow * ((samples.position_m[row] - samples.position_m[last]) / period_s - speed_mps)
        share = _share(min_cutoff_hz + beta_per_m * np.abs(speed_mps), period_s)
        position_m[row] = position_m[last] + share * (samples.position_m[row] - position_m[last])

        step = rotations.multiply(samples.rotation[row], rotations.conjugate(samples.rotation[last]))
        turning_radps += slow * (_vector(step) / period_s - turning_radps)
        share = _share(min_cutoff_hz + beta_per_m * np.linalg.norm(turning_radps), period_s)
        left = rotations.multiply(samples.rotation[row], rotations.conjugate(rotation[last]))
        rotation[row] = rotations.multiply(rotations.from_vector(share * _vector(left)), rotation[last])
    return dataclasses.replace(samples, position_m=position_m, rotation=rotation)


def _vector(step: np.ndarray) -> np.ndarray:
    """Returns the rotation vector of `step`, for the quaternion sign with the smaller angle."""
    return rotations.to_vector(step if step[0] >= 0.0 else -step)
