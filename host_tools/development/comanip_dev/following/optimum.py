"""Estimates how closely the arm, within its limits, could follow a motion that is known in advance.

Inverse kinematics computes the joint path for the instantaneous targets. Among the paths that keep the limits of
position, speed and acceleration, ADMM then finds the one closest to that joint path in the least-squares sense. The arm
could follow the path that ADMM finds, so the error of this path is an upper bound on the smallest possible error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded

from comanip_dev.following import metrics
from comanip_dev.following.arm_model import ArmModel
from comanip_dev.following.case import ACCELERATION_MAX_RADPS2, Scene, target_path
from comanip_dev.following.posture_path import posture_path

STEP_S = 5e-3
ITERATIONS = 400
RESERVE = 0.995  # ADMM gets limits reduced to this share, so that slight violations stay within the actual limits
PENALTY = 30.0
FOLLOWABLE_MM = 0.5


@dataclass(frozen=True)
class Optimum:
    rms_mm: float
    max_mm: float
    unreached_mm: float  # largest distance between a target and the nearest reachable position
    acceleration_radps2: float  # largest acceleration of the path
    speed_radps: float

    @property
    def is_followable(self) -> bool:
        return self.rms_mm < FOLLOWABLE_MM and self.acceleration_radps2 <= ACCELERATION_MAX_RADPS2


def _differences(q: np.ndarray, order: int) -> np.ndarray:
    return np.diff(q, order, axis=0)


def _transposed(d: np.ndarray, order: int) -> np.ndarray:
    """Applies the adjoint of _differences(): (T - order, n) -> (T, n)."""
    for _ in range(order):
        d = np.diff(d, axis=0, prepend=0.0, append=0.0) * -1.0
    return d


def _gram(count: int, order: int) -> np.ndarray:
    """Returns the main and the two lower diagonals (3, count) of D^T D, where D is the matrix of _differences()."""
    stencil = {1: [-1.0, 1.0], 2: [1.0, -2.0, 1.0]}[order]
    bands = np.zeros((3, count))
    for row in range(order + 1):
        for column in range(row + 1):
            bands[row - column, column : count - order + column] += stencil[row] * stencil[column]
    return bands


def within_limits(
    q: np.ndarray, step_s: float, position: tuple[np.ndarray, np.ndarray], speed: np.ndarray, acceleration: float
) -> np.ndarray:
    """Returns the path (T, n) closest to q among those that keep the limits of position (two arrays (n,)), speed ((n,)
    in rad/s) and acceleration (in rad/s^2)."""
    bounds = {
        0: position,
        1: (-speed * step_s * RESERVE, speed * step_s * RESERVE),
        2: (-acceleration * step_s**2 * RESERVE, acceleration * step_s**2 * RESERVE),
    }
    weight = {0: 1.0, 1: PENALTY, 2: PENALTY**2}
    bands = np.zeros((3, len(q)))
    bands[0] = 1.0 + weight[0]
    for order in (1, 2):
        bands += weight[order] * _gram(len(q), order)
    factor = cholesky_banded(bands, lower=True)
    x = q.copy()
    split = {order: np.clip(_differences(q, order), *bounds[order]) for order in bounds}
    dual = {order: np.zeros_like(part) for order, part in split.items()}
    for _ in range(ITERATIONS):
        right = q + sum(weight[o] * _transposed(split[o] - dual[o], o) for o in bounds)
        x = cho_solve_banded((factor, True), right)
        for order in bounds:
            part = _differences(x, order) + dual[order]
            split[order] = np.clip(part, *bounds[order])
            dual[order] = part - split[order]
    return x


def optimum(arm: ArmModel, scene: Scene) -> Optimum:
    """Returns the optimum over the motion. Before the motion, the arm rests in its start posture."""
    motion = scene.motion
    t_s = np.arange(motion.begin_s - 0.5, motion.end_s, STEP_S)
    target_m, _ = target_path(arm, scene, t_s)
    q, distance_m = posture_path(arm, scene.start_rad, t_s, target_m)
    limits = (arm.position_min_rad, arm.position_max_rad)
    path = within_limits(q, STEP_S, limits, arm.velocity_max_radps, ACCELERATION_MAX_RADPS2)
    error_mm = metrics.errors_mm(arm.hand(path)[0], target_m)[t_s >= motion.begin_s]
    return Optimum(
        rms_mm=metrics.rms(error_mm),
        max_mm=float(error_mm.max()),
        unreached_mm=1e3 * float(distance_m.max()),
        acceleration_radps2=float(np.abs(np.diff(path, 2, axis=0)).max()) / STEP_S**2,
        speed_radps=float(np.abs(np.diff(path, axis=0)).max()) / STEP_S,
    )
