"""Computes rotations and, with the firmware's code, the points of the arm's links."""

from __future__ import annotations

import numpy as np

from comanip import core
from comanip._core import ffi, lib
from comanip.core.arm import Arm

ARM = "hoap3_right"


def rotate(rotation: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Rotates vectors by unit quaternions (N, 4), w first, and returns the results (N, 3). vector: one vector for all
    rotations (3,), or one for each rotation (N, 3)."""
    w, axis = rotation[:, :1], rotation[:, 1:]
    vector = np.broadcast_to(vector, axis.shape)
    cross = 2.0 * np.cross(axis, vector)
    return vector + w * cross + np.cross(axis, cross)


def angle_between_deg(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Returns the angles of the rotations from a to b in degrees, 0 to 180: (N, 4), (N, 4) -> (N,). a and b are unit
    quaternions, whose signs do not matter."""
    cosine = np.abs((a * b).sum(axis=1))
    # Computed from |a - b| and |a + b|, because the arc cosine is inaccurate for small angles.
    nearer = np.minimum(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
    return np.degrees(4.0 * np.arctan2(nearer / 2.0, np.sqrt((1.0 + cosine) / 2.0)))


def tilt_deg(rotation: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Returns the angles in degrees between the torso's z axis and the axis (3,) of a body that is rotated by the unit
    quaternions (N, 4): (N,)."""
    return np.degrees(np.arccos(np.clip(rotate(rotation, axis)[:, 2], -1.0, 1.0)))


def _translation(poses: np.ndarray) -> np.ndarray:
    """Returns the translations of poses: (N, 8) -> (N, 3)."""
    padding = np.zeros((len(poses), 4), np.float32)
    dual = np.ascontiguousarray(np.hstack([poses[:, 4:], padding]))
    primary = np.ascontiguousarray(np.hstack([poses[:, :4], padding]))
    return 2.0 * core.multiply(dual, core.conjugate(primary))[:, 1:4]


def _first_joints(arm: Arm, count: int) -> Arm:
    """Returns an arm that consists of the first `count` joints, without an end effector."""
    rows = [arm.table.joints[i] for i in range(count)]
    fixed = np.array([np.frombuffer(ffi.buffer(ffi.new("dual_quaternion_t *", pose)), np.float32)
                      for pose in (lib.pose_to_dual_quaternion(row.fixed) for row in rows)])  # fmt: skip
    axis = np.array([np.frombuffer(ffi.buffer(ffi.addressof(row, "axis")), np.float32) for row in rows])
    limits = (arm.position_min_rad[:count], arm.position_max_rad[:count], arm.velocity_max_radps[:count])
    return Arm(fixed, axis, *(limit.copy() for limit in limits))


def arm_points_m(joints_rad: np.ndarray) -> np.ndarray:
    """Returns the origins of all joints and the position of the hand, in torso axes: (N, n) -> (N, n + 1, 3)."""
    q = np.ascontiguousarray(joints_rad, np.float32)
    arm = Arm.named(ARM)
    parts = [_first_joints(arm, k) for k in range(1, arm.joint_count + 1)]
    poses = [core.forward_kinematics(part, np.ascontiguousarray(q[:, : part.joint_count])) for part in parts]
    return np.stack([_translation(pose) for pose in [*poses, core.forward_kinematics(arm, q)]], axis=1)
