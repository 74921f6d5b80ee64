"""Computes forward and inverse kinematics of the arm in double precision, for many postures at once."""

from __future__ import annotations

import numpy as np
from comanip.core.arm import Arm, resolve

from comanip_dev.following import rotations

MAX_ITERATIONS = 60
DAMPING_M2 = 1e-6
LARGEST_STEP_RAD = 0.2


def _quaternion(q) -> np.ndarray:
    rotation = np.array([q.w, q.x, q.y, q.z], float)
    return rotation / np.linalg.norm(rotation)


def _vector(v) -> np.ndarray:
    return np.array([v.x, v.y, v.z], float)


class ArmModel:
    def __init__(self, arm: str | Arm) -> None:
        self.arm = resolve(arm)
        table = self.arm.table
        joints = [table.joints[i] for i in range(table.joint_count)]
        self.joint_count = len(joints)
        self.fixed = [(_quaternion(j.fixed.rotation), _vector(j.fixed.translation_m)) for j in joints]
        self.axis = [_vector(j.axis) / np.linalg.norm(_vector(j.axis)) for j in joints]
        self.effector = _quaternion(table.effector.rotation), _vector(table.effector.translation_m)
        self.position_min_rad = self.arm.position_min_rad.astype(float)
        self.position_max_rad = self.arm.position_max_rad.astype(float)
        self.velocity_max_radps = self.arm.velocity_max_radps.astype(float)

    def hand(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns the end effector's poses in the torso frame at joint angles (N, n): positions in m (N, 3) and
        rotations (N, 4)."""
        position_m, rotation, _, _ = self._chain(q)
        return position_m, rotation

    def position_jacobian(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns the end effector's positions (N, 3) and their derivatives (N, 3, n) in m/rad."""
        position_m, _, axis, origin_m = self._chain(q)
        return position_m, np.stack(
            [rotations.cross(a, position_m - o) for a, o in zip(axis, origin_m, strict=True)], axis=2
        )

    def _chain(self, q: np.ndarray):
        rotation = np.tile([1.0, 0.0, 0.0, 0.0], (len(q), 1))
        position_m = np.zeros((len(q), 3))
        axis, origin_m = [], []
        for i, (turn, way_m) in enumerate(self.fixed):
            position_m = position_m + rotations.rotate(rotation, way_m)
            rotation = rotations.multiply(rotation, turn)
            axis.append(rotations.rotate(rotation, self.axis[i]))
            origin_m.append(position_m)
            rotation = rotations.multiply(rotation, rotations.from_vector(q[:, i : i + 1] * self.axis[i]))
        turn, way_m = self.effector
        position_m = position_m + rotations.rotate(rotation, way_m)
        return position_m, rotations.multiply(rotation, turn), axis, origin_m

    def reach(self, target_m: np.ndarray, start_rad: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Finds postures that bring the end effector to the targets (N, 3), by damped Gauss-Newton steps from start_rad
        (N, n) within the joint limits. Returns the best postures found (N, n) and the remaining distances in m
        (N,)."""
        q = np.clip(start_rad, self.position_min_rad, self.position_max_rad)
        best, nearest_m = q.copy(), np.full(len(q), np.inf)
        for _ in range(MAX_ITERATIONS):
            position_m, jacobian = self.position_jacobian(q)
            error_m = target_m - position_m
            distance_m = np.linalg.norm(error_m, axis=1)
            better = distance_m < nearest_m
            best[better], nearest_m[better] = q[better], distance_m[better]
            if nearest_m.max() < 1e-7:
                break
            pull = np.einsum("nki,nk->ni", jacobian, error_m)
            stuck = (q <= self.position_min_rad) & (pull < 0.0) | (q >= self.position_max_rad) & (pull > 0.0)
            jacobian = np.where(stuck[:, None, :], 0.0, jacobian)
            gram = jacobian @ jacobian.transpose(0, 2, 1) + DAMPING_M2 * np.eye(3)
            step = np.einsum("nki,nk->ni", jacobian, np.linalg.solve(gram, error_m[:, :, None])[:, :, 0])
            step *= np.minimum(1.0, LARGEST_STEP_RAD / np.maximum(np.abs(step).max(axis=1, keepdims=True), 1e-12))
            q = np.clip(q + step, self.position_min_rad, self.position_max_rad)
        return best, nearest_m
