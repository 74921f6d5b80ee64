"""A path of postures along a path of the hand."""

from __future__ import annotations

import numpy as np

from comanip_dev.following.arm_model import ArmModel

COARSE_S = 0.05


def posture_path(
    arm: ArmModel, start_rad: np.ndarray, t_s: np.ndarray, target_m: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Postures (N, n) within the joints' ranges whose hands are at the targets (N, 3) of the times t_s (N,), or as near
    as they can be, and the distances left in m (N,). One follows from the other with the least motion of the joints: on
    a coarse grid step by step, between by correcting the interpolation."""
    stride = max(1, round(COARSE_S / float(np.median(np.diff(t_s)))))
    coarse = np.unique(np.append(np.arange(0, len(t_s), stride), len(t_s) - 1))
    postures = [start_rad]
    for row in coarse:
        found, _ = arm.reach(target_m[row : row + 1], postures[-1][None])
        postures.append(found[0])
    known = np.array(postures[1:])
    guess = np.column_stack([np.interp(t_s, t_s[coarse], known[:, i]) for i in range(known.shape[1])])
    return arm.reach(target_m, guess)
