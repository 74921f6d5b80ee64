"""Computes the geometry of HOAP-3's right arm in double precision, from the manual's table and independently of the
firmware: the end effector's position, the positions that it can reach, and the shape of the position error around a
posture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

SHOULDER_M = np.array([-0.035, -0.111, 0.125])
UPPER_M, FORE_M = 0.111, 0.171
RANGE_RAD = np.radians([[-90.0, 150.0], [-95.0, 0.0], [-90.0, 90.0], [-114.0, 0.0]])
SWIVELS = 1801  # number of upper arm torsion angles tried for each position, one every 0.1 degree
STEP_RAD = 1e-4  # step of the finite differences


def hand_m(q: np.ndarray) -> np.ndarray:
    """Returns the end effector's position (..., 3) in the torso frame at the joint angles (..., 4)."""
    (s1, s2, s3, s4), (c1, c2, c3, c4) = np.sin(np.moveaxis(q, -1, 0)), np.cos(np.moveaxis(q, -1, 0))
    side, along = -FORE_M * s4, UPPER_M + FORE_M * c4  # in the upper arm's frame
    x, y = -side * s3, side * c3
    up = x * c2 + along * s2
    out, across = -x * s2 + along * c2, -y
    return SHOULDER_M + np.stack([out * c1 - across * s1, up, -(out * s1 + across * c1)], axis=-1)


def reaching(position_m: np.ndarray) -> np.ndarray:
    """Returns postures (n, 4) within the joint limits that bring the end effector to the position. There are at most
    two for each torsion angle tried, and none if the position is out of reach. The elbow angle follows from the
    distance, and the first two joints follow from each torsion angle."""
    w = np.asarray(position_m, float) - SHOULDER_M
    cosine = (w @ w - UPPER_M**2 - FORE_M**2) / (2 * UPPER_M * FORE_M)
    if abs(cosine) > 1:
        return np.empty((0, 4))
    q4 = -np.arccos(cosine)
    q3 = np.linspace(*RANGE_RAD[2], SWIVELS)
    side, along = -FORE_M * np.sin(q4), UPPER_M + FORE_M * cosine
    x, y = -side * np.sin(q3), side * np.cos(q3)
    # w_y = x cos q2 + along sin q2
    amplitude, phase = np.hypot(x, along), np.arctan2(x, along)
    possible = np.abs(w[1]) <= amplitude
    q3, x, y, amplitude, phase = (v[possible] for v in (q3, x, y, amplitude, phase))
    rise = np.arcsin(w[1] / amplitude)
    found = []
    for q2 in (rise - phase, np.pi - rise - phase):
        out, across = -x * np.sin(q2) + along * np.cos(q2), -y
        q1 = np.arctan2(-w[2], w[0]) - np.arctan2(across, out)
        found.append(np.stack([q1, q2, q3, np.full_like(q3, q4)], axis=1))
    q = np.concatenate(found)
    q[:, :2] = (q[:, :2] + np.pi) % (2 * np.pi) - np.pi
    return q[((q >= RANGE_RAD[:, 0]) & (q <= RANGE_RAD[:, 1])).all(axis=1)]


@dataclass(frozen=True)
class Valley:
    """Describes how half the squared distance to a position varies around a posture. Slope, curvature and singular
    value leave out each joint that is at a limit and that the slope would push beyond it, as the control law does."""

    error_m: float
    limits: tuple[int, ...]  # joints at a limit, counted from 1
    slope_m2: float  # slope of the steepest descent by the remaining joints [m^2/rad]
    curvature_m2: np.ndarray  # eigenvalues of the Hessian [m^2/rad^2], ascending
    singular_m: float  # the Jacobian's smallest singular value [m/rad]
    reachable: bool


AT_LIMIT_RAD = 5e-3  # a joint this close to a limit counts as at it, because the firmware stops joints before the limit


def jacobian_m(q: np.ndarray) -> np.ndarray:
    """Returns the Jacobian (..., 3, 4) of hand_m()."""
    steps = STEP_RAD * np.eye(4)
    return np.stack([(hand_m(q + step) - hand_m(q - step)) / (2 * STEP_RAD) for step in steps], axis=-1)


def hessian_m2(q: np.ndarray, error_m: np.ndarray) -> np.ndarray:
    """Returns the Hessian (4, 4) of half the squared distance."""
    jacobian = jacobian_m(q)
    steps = STEP_RAD * np.eye(4)
    bend = np.stack([(jacobian_m(q + step) - jacobian_m(q - step)) / (2 * STEP_RAD) for step in steps], axis=-1)
    return jacobian.T @ jacobian - np.einsum("i,ijk->jk", error_m, 0.5 * (bend + np.swapaxes(bend, 1, 2)))


def valley(q: np.ndarray, position_m: np.ndarray) -> Valley:
    q = np.asarray(q, float)
    error = np.asarray(position_m, float) - hand_m(q)
    jacobian = jacobian_m(q)
    downhill = jacobian.T @ error
    low, high = q - RANGE_RAD[:, 0] < AT_LIMIT_RAD, RANGE_RAD[:, 1] - q < AT_LIMIT_RAD
    out = (low & (downhill < 0)) | (high & (downhill > 0))
    free = ~out
    singular = np.linalg.svd(jacobian[:, free], compute_uv=False) if free.any() else np.zeros(1)
    return Valley(
        float(np.linalg.norm(error)), tuple(int(i) + 1 for i in np.flatnonzero(low | high)),
        float(np.linalg.norm(downhill[free])), np.linalg.eigvalsh(hessian_m2(q, error)[np.ix_(free, free)]),
        float(singular.min()), len(reaching(position_m)) > 0,
    )  # fmt: skip


CAP_M, STEP_SHARE, STEP_MAX_RAD, DESCENT_STEPS, DAMPING_M2 = 0.015, 0.2, 0.02, 1500, 1e-6


def descend(q: np.ndarray, position_m: np.ndarray) -> np.ndarray:
    """Descends from the postures (n, 4) towards the position, ignoring orientation, and returns the final postures.
    Takes small Gauss-Newton steps within the joint limits. The remaining error is a local minimum of the distance."""
    low, high = RANGE_RAD.T
    q = np.clip(q, low, high)
    for _ in range(DESCENT_STEPS):
        error = position_m - hand_m(q)
        error = error * np.minimum(1, CAP_M / np.maximum(np.linalg.norm(error, axis=1, keepdims=True), 1e-12))
        jacobian = jacobian_m(q)
        downhill = np.einsum("nij,ni->nj", jacobian, error)
        square = np.einsum("nki,nkj->nij", jacobian, jacobian) + DAMPING_M2 * np.eye(4)
        free = np.ones(q.shape, bool)
        for _ in range(q.shape[1]):
            normal = square * free[:, :, None] * free[:, None, :] + np.eye(4) * ~free[:, :, None]
            step = np.linalg.solve(normal, (downhill * free)[:, :, None])[:, :, 0]
            free &= ~(((q <= low) & (step < 0)) | ((q >= high) & (step > 0)))
        step = STEP_SHARE * step * free
        step *= np.minimum(1, STEP_MAX_RAD / np.maximum(np.abs(step).max(axis=1, keepdims=True), 1e-12))
        q = np.clip(q + step, low, high)
    return q
