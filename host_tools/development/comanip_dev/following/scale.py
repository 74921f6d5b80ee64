"""Finds the largest scale of a recording at which the arm can reach every target."""

from __future__ import annotations

import numpy as np

from comanip_dev.following.arm_model import ArmModel
from comanip_dev.following.recorded_hand import HandMotion, Recording
from comanip_dev.following.target import targets

SHARE = 0.9  # recordings are played at this share of the largest scale
REACHED_M = 1e-4
POINTS = 150
LARGEST = 10.0
GROWTH = 1.1
BISECTIONS = 8


def largest_scale(
    arm: ArmModel, task: str, start_rad: np.ndarray, recording: Recording, rotation_scale: float
) -> float:
    """Returns the largest position scale such that, at this and at all smaller scales, the arm can reach every target
    of the motion within the joint limits."""
    start_m, start_rotation = arm.hand(start_rad[None])
    at_s = np.linspace(0.0, recording.duration_s, POINTS)
    displacement_m, turn = HandMotion(recording, 1.0, rotation_scale, 0.0, 0.0).displacement(at_s)

    def reach(scale: float, posture_rad: np.ndarray) -> tuple[np.ndarray, bool]:
        target_m, _ = targets(task, start_m[0], start_rotation[0], scale * displacement_m, turn)
        found_rad, distance_m = arm.reach(target_m, posture_rad)
        return found_rad, bool(distance_m.max() < REACHED_M)

    scale, posture_rad = 0.002, np.tile(start_rad, (POINTS, 1))
    while scale < LARGEST:
        found_rad, reached = reach(scale * GROWTH, posture_rad)
        if not reached:
            break
        scale, posture_rad = scale * GROWTH, found_rad
    low, high = scale, scale * GROWTH
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        _, reached = reach(middle, posture_rad)
        low, high = (middle, high) if reached else (low, middle)
    return low
