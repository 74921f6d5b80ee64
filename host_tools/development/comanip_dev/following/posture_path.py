"""Computes a path of postures for a path of the end effector."""

from __future__ import annotations

import numpy as np

from comanip_dev.following.arm_model import ArmModel

COARSE_S = 0.05


def posture_path(
    arm: ArmModel, start_rad: np.ndarray, t_s: np.ndarray, target_m: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Returns postures (N, n) within the joint limits that bring the end effector as close as possible to the targets
    (N, 3) at the times t_s (N,), and the remaining distances in m (N,). On a coarse time grid, the search for each
    posture starts from the previous one. Between the grid points, each search starts from an interpolated posture."""
    stride = max(1, round(COARSE_S / float(np.median(np.diff(t_s)))))
    coarse = np.unique(np.append(np.arange(0, len(t_s), stride), len(t_s) - 1))
    postures = [start_rad]
    for row in coarse:
        found, _ = arm.reach(target_m[row : row + 1], postures[-1][None])
        postures.append(found[0])
    known = np.array(postures[1:])
    guess = np.column_stack([np.interp(t_s, t_s[coarse], known[:, i]) for i in range(known.shape[1])])
    return arm.reach(target_m, guess)
