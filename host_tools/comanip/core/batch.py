"""The functions of ``comanip.core`` that work row by row. Each calls a loop in C (``_binding/batch.h``)."""

from __future__ import annotations

import numpy as np

from comanip._core import ffi, lib
from comanip.core import checks as check
from comanip.core.arm import Arm, resolve
from comanip.core.cooperation import choice, enumerators

_ERROR_FRAMES = enumerators("error_frame_t", "ERROR_FRAME_")


def _dual_quaternions(values: np.ndarray):
    return check.pointer("dual_quaternion_t", values)


def _floats(values: np.ndarray):
    return check.pointer("float", values)


def _joint_positions(arm: Arm, q: object) -> np.ndarray:
    checked = check.array("q", q, ("N", arm.joint_count))
    most = lib.TRIGONOMETRY_MAX_RAD
    if checked.size and np.abs(checked).max() > most:
        raise ValueError(f"q: expected angles within +-{most:g} rad, got {checked.flat[np.abs(checked).argmax()]:g}")
    return checked


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Returns the products a b, row by row: (N, 8), (N, 8) -> (N, 8)."""
    a, b = check.array("a", a, ("N", 8)), check.array("b", b, ("N", 8))
    check.same_length("a", a, "b", b)
    out = np.empty_like(a)
    lib.batch_multiply(len(a), _dual_quaternions(a), _dual_quaternions(b), _dual_quaternions(out))
    return out


def conjugate(a: np.ndarray) -> np.ndarray:
    """Returns the conjugates: (N, 8) -> (N, 8). The primary and the dual part are both conjugated. The conjugate of a
    pose is the inverse of the pose."""
    a = check.array("a", a, ("N", 8))
    out = np.empty_like(a)
    lib.batch_conjugate(len(a), _dual_quaternions(a), _dual_quaternions(out))
    return out


def normalise(a: np.ndarray) -> np.ndarray:
    """Normalises to unit dual quaternions: (N, 8) -> (N, 8). In the result, the primary part P and the dual part D
    satisfy |P| = 1 and P . D = 0. In the argument, |P| must be between 1e-12 and 1e12, so that |P|^2 fits into
    float32."""
    a = check.array("a", a, ("N", 8))
    norm = np.linalg.norm(a[:, :4].astype(float), axis=1)
    bad = (norm < 1e-12) | (norm > 1e12)
    if bad.any():
        row = int(bad.argmax())
        raise ValueError(f"a: row {row} has a primary part of norm {norm[row]:.3g}, expected 1e-12 to 1e12")
    out = np.empty_like(a)
    lib.batch_normalise(len(a), _dual_quaternions(a), _dual_quaternions(out))
    return out


def decompositional_multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Evaluates equation (6) of the paper, T{b} T{a} P(b) P(a), for poses, row by row: (N, 8), (N, 8) -> (N, 8)."""
    a, b = check.poses("a", a), check.poses("b", b)
    check.same_length("a", a, "b", b)
    out = np.empty_like(a)
    lib.batch_decompositional_multiply(len(a), _dual_quaternions(a), _dual_quaternions(b), _dual_quaternions(out))
    return out


def pose_from_matrix(R: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Converts rotation matrices and translations [m] to poses (footnote 1 of the paper):
    (N, 3, 3), (N, 3) -> (N, 8)."""
    R, t = check.rotation_matrices("R", R), check.array("t", t, ("N", 3))
    check.same_length("R", R, "t", t)
    out = np.empty((len(R), 8), np.float32)
    lib.batch_pose_from_matrix(len(R), _floats(R), check.pointer("vector3_t", t), _dual_quaternions(out))
    return out


def forward_kinematics(arm: str | Arm, q: np.ndarray) -> np.ndarray:
    """Returns the end effector's pose in the torso frame at the joint positions q [rad]: (N, n) -> (N, 8)."""
    arm = resolve(arm)
    q = _joint_positions(arm, q)
    out = np.empty((len(q), 8), np.float32)
    lib.batch_forward_kinematics(arm.table, len(q), _floats(q), _dual_quaternions(out))
    return out


def pose_jacobian(arm: str | Arm, q: np.ndarray) -> np.ndarray:
    """Returns the derivative of forward_kinematics() with respect to q: (N, n) -> (N, 8, n). Two dual quaternions
    represent each pose. The derivative is that of the one that forward_kinematics() returns."""
    arm = resolve(arm)
    q = _joint_positions(arm, q)
    out = np.empty((len(q), 8, arm.joint_count), np.float32)
    lib.batch_pose_jacobian(arm.table, len(q), _floats(q), _floats(out))
    return out


def joint_velocity(
    arm: str | Arm,
    q: np.ndarray,
    target: np.ndarray,
    gain: float | np.ndarray,
    damping: float,
    error_frame: str = "torso",
    weight: float | np.ndarray | None = None,
) -> np.ndarray:
    """Computes differential inverse kinematics (damped least squares, equation (4) of the paper) without limits:
    u = (J^T W J + damping I)^-1 J^T W K e [rad/s], (N, n), (N, 8) -> (N, n).

    gain, weight: the diagonals of K and W, as a number or (8,). If weight is None, W is the identity, as in the paper.
    error_frame: with the end effector's pose x and the target x_d, "torso" uses e = x_d - x, as in the paper. "target"
    uses e = 1 - conj(x_d) x with the Jacobian conj(x_d) J.
    """
    arm = resolve(arm)
    q, target = _joint_positions(arm, q), check.poses("target", target)
    check.same_length("q", q, "target", target)
    choice("error_frame", error_frame, _ERROR_FRAMES)
    config = ffi.new("differential_ik_config_t *")
    config.gain_per_s = check.diagonal("gain", gain)
    config.weight = check.diagonal("weight", 1.0 if weight is None else weight)
    config.damping = check.scalar("damping", damping, 0.0)
    config.error_frame = _ERROR_FRAMES[error_frame]
    lib.differential_ik_prepare(config)
    out = np.empty((len(q), arm.joint_count), np.float32)
    lib.batch_joint_velocity(arm.ik, config, len(q), _floats(q), _dual_quaternions(target), _floats(out))
    return out
