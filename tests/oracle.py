"""Provides double-precision references, written independently of the firmware. They are the paper's equations, both in
numpy for arrays and term by term with dqrobotics, and HOAP-3's right arm from Fujitsu's manual.

Quaternions are (..., 4) in the order w x y z, dual quaternions (..., 8), as in the paper.
"""

from __future__ import annotations

import dqrobotics
import numpy as np
from dqrobotics import DQ
from dqrobotics.robot_modeling import DQ_SerialManipulatorDH, DQ_SerialManipulatorMDH

# ---- quaternions and poses


def quaternion_multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Multiplies quaternions component by component, because numpy's cross product takes ten times as long for a single
    product."""
    aw, ax, ay, az = (a[..., i] for i in range(4))
    bw, bx, by, bz = (b[..., i] for i in range(4))
    w = aw * bw - (ax * bx + ay * by + az * bz)
    product = np.empty((*w.shape, 4), w.dtype)
    product[..., 0] = w
    product[..., 1] = aw * bx + bw * ax + (ay * bz - az * by)
    product[..., 2] = aw * by + bw * ay + (az * bx - ax * bz)
    product[..., 3] = aw * bz + bw * az + (ax * by - ay * bx)
    return product


def quaternion_conjugate(a: np.ndarray) -> np.ndarray:
    return a * np.array([1.0, -1.0, -1.0, -1.0])


def rotation(axis, angle_rad) -> np.ndarray:
    """Returns the paper's q(axis, angle)."""
    axis = np.asarray(axis, float)
    half = np.asarray(angle_rad, float)[..., None] / 2
    return np.concatenate([np.cos(half), np.sin(half) * axis / np.linalg.norm(axis, axis=-1, keepdims=True)], axis=-1)


def rotation_matrix(q: np.ndarray) -> np.ndarray:
    w, x, y, z = np.moveaxis(np.asarray(q, float), -1, 0)
    return np.moveaxis(
        np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        ),
        (0, 1),
        (-2, -1),
    )


def rotate(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    return (rotation_matrix(q) @ np.asarray(v, float)[..., None])[..., 0]


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    dual = quaternion_multiply(a[..., :4], b[..., 4:]) + quaternion_multiply(a[..., 4:], b[..., :4])
    return np.concatenate([quaternion_multiply(a[..., :4], b[..., :4]), dual], axis=-1)


def conjugate(a: np.ndarray) -> np.ndarray:
    return np.concatenate([quaternion_conjugate(a[..., :4]), quaternion_conjugate(a[..., 4:])], axis=-1)


def pose(r: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Returns the unit dual quaternion r + eps 1/2 t r."""
    r, t = np.asarray(r, float), np.asarray(t, float)
    pure = np.concatenate([np.zeros((*t.shape[:-1], 1)), t], axis=-1)
    return np.concatenate([r, 0.5 * quaternion_multiply(pure, r)], axis=-1)


def translation(x: np.ndarray) -> np.ndarray:
    x = np.asarray(x, float)
    return 2 * quaternion_multiply(x[..., 4:], quaternion_conjugate(x[..., :4]))[..., 1:]


def random_rotations(rng: np.random.Generator, count: int) -> np.ndarray:
    q = rng.normal(size=(count, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def random_poses(rng: np.random.Generator, count: int, reach_m: float = 1.0) -> np.ndarray:
    """Returns random unit dual quaternions, rounded to float32 as the firmware receives them."""
    return pose(random_rotations(rng, count), rng.uniform(-reach_m, reach_m, (count, 3))).astype(np.float32)


def pose_distance(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Returns the largest difference between components of a and b, or of a and -b if that is smaller, because b and -b
    are the same pose."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    return np.minimum(np.abs(a - b).max(-1), np.abs(a + b).max(-1))


def rotation_angle(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Returns the angle [rad] between the rotations of two poses."""
    difference = quaternion_multiply(quaternion_conjugate(np.asarray(a, float)[..., :4]), np.asarray(b, float)[..., :4])
    return 2 * np.arctan2(np.linalg.norm(difference[..., 1:], axis=-1), np.abs(difference[..., 0]))


# ---- control law (4)


def law(
    jacobian: np.ndarray, hand: np.ndarray, target: np.ndarray, gain, weight, damping: float, error_frame: str
) -> np.ndarray:
    """Returns (J^T W J + lambda I)^-1 J^T W K e, one row per posture. x and -x are the same target; the error is
    computed with the one that is nearer to the end effector."""
    gain, weight = np.broadcast_to(gain, 8).astype(float), np.broadcast_to(weight, 8).astype(float)
    sign = np.where((target[:, :4] * hand[:, :4]).sum(1, keepdims=True) < 0, -1.0, 1.0)
    target = sign * target
    if error_frame == "target":
        back = conjugate(target)
        error = np.array([1, 0, 0, 0, 0, 0, 0, 0.0]) - multiply(back, hand)
        jacobian = multiply(back[:, None, :], jacobian.swapaxes(1, 2)).swapaxes(1, 2)
    else:
        error = target - hand
    weighted = np.swapaxes(jacobian, 1, 2) * weight
    normal = weighted @ jacobian + damping * np.eye(jacobian.shape[2])
    return np.linalg.solve(normal, weighted @ (gain * error)[..., None])[..., 0]


# ---- arms

HOAP3_DH = np.array(  # theta, d, a, alpha: the manual's chain in standard DH form
    [
        [0, np.pi / 2, np.pi / 2, 0],
        [0, 0, 0.111, 0],
        [0, 0, 0, 0],
        [np.pi / 2, np.pi / 2, np.pi / 2, -np.pi / 2],
    ]
)
HOAP3_MDH = np.array(  # the manual's modified DH from torso to chest to arm; the end effector is at 0.171 along y4
    [
        [0, 0, 0, np.pi / 2, np.pi / 2, 0],
        [0.125, -0.111, 0, 0, 0.111, 0],
        [-0.035, 0, 0, 0, 0, 0],
        [0, -np.pi / 2, 0, np.pi / 2, np.pi / 2, np.pi / 2],
    ]
)
HOAP3_RANGE_DEG = np.array([[-91, -96, -91, -115], [151, 1, 91, 1]])


def unit(x: np.ndarray) -> np.ndarray:
    """Returns the nearest unit dual quaternion in double precision. dqrobotics rejects poses that are unit only in
    float32."""
    x = np.asarray(x, float) / np.linalg.norm(np.asarray(x, float)[..., :4], axis=-1, keepdims=True)
    dual = x[..., 4:] - (x[..., :4] * x[..., 4:]).sum(-1, keepdims=True) * x[..., :4]
    return np.concatenate([x[..., :4], dual], axis=-1)


def dq(x: np.ndarray) -> DQ:
    x = np.asarray(x, float)
    return DQ(unit(x) if x.shape[-1] == 8 else x / np.linalg.norm(x))


def hoap3() -> DQ_SerialManipulatorDH:
    arm = DQ_SerialManipulatorDH(np.vstack([HOAP3_DH, np.zeros(4)]))
    base = dq(pose(rotation([1, 0, 0], -np.pi / 2), [-0.035, -0.111, 0.125]))
    arm.set_base_frame(base)
    arm.set_reference_frame(base)
    arm.set_effector(dq(pose([1.0, 0, 0, 0], [0, 0, 0.171])))
    return arm


def hoap3_from_manual(q: np.ndarray) -> np.ndarray:
    """Returns the end effector pose from the manual's modified DH table. The table's two fixed rows are treated as
    joints that stay at 0."""
    chain = DQ_SerialManipulatorMDH(np.vstack([HOAP3_MDH, np.zeros(6)]))
    frame4 = chain.fkm(np.concatenate([[0, 0], np.asarray(q, float)]))
    hand = dq(pose([1.0, 0, 0, 0], [0, 0.171, 0])) * dq(rotation([1, 0, 0], -np.pi / 2))
    return (frame4 * hand).vec8()


def evaluate(arm, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns the end effector poses (N, 8) and Jacobians (N, 8, n) as computed by dqrobotics."""
    hands = np.array([arm.fkm(row).vec8() for row in np.asarray(q, float)])
    return hands, np.array([arm.pose_jacobian(row) for row in np.asarray(q, float)])


def dh_chain(theta, d, a, alpha, base=None, effector=None) -> tuple[np.ndarray, np.ndarray]:
    """Converts a standard DH chain. Returns n fixed transforms (n, 8), one before each joint's rotation about z, and
    the transform from the last joint to the end effector."""
    one = np.array([1, 0, 0, 0, 0, 0, 0, 0.0])
    before, fixed = one if base is None else base, []
    for theta_i, d_i, a_i, alpha_i in zip(theta, d, a, alpha):
        fixed.append(multiply(before, pose(rotation([0, 0, 1], theta_i), np.zeros(3))))
        before = pose(rotation([1, 0, 0], alpha_i), [a_i, 0, d_i])
    return np.array(fixed), multiply(before, one if effector is None else effector)


def chain_kinematics(
    fixed: np.ndarray, axis: np.ndarray, effector: np.ndarray, q: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the end effector poses (N, 8) and Jacobians (N, 8, n) of an arm that is described by arguments of
    core.Arm. By the product rule, column i of the Jacobian is the chain's product with the i-th rotation replaced by
    its derivative."""
    count, n = q.shape
    turn = np.zeros((n, count, 8))
    slope = np.zeros((n, count, 8))
    for i in range(n):
        half = q[:, i, None].astype(float) / 2
        turn[i, :, :4] = np.concatenate([np.cos(half), np.sin(half) * axis[i]], axis=1)
        slope[i, :, :4] = 0.5 * np.concatenate([-np.sin(half), np.cos(half) * axis[i]], axis=1)

    def product(factors) -> np.ndarray:
        x = np.broadcast_to(np.array([1, 0, 0, 0, 0, 0, 0, 0.0]), (count, 8))
        for i in range(n):
            x = multiply(multiply(x, np.broadcast_to(fixed[i].astype(float), (count, 8))), factors[i])
        return multiply(x, np.broadcast_to(effector.astype(float), (count, 8)))

    columns = [product([slope[j] if j == i else turn[j] for j in range(n)]) for i in range(n)]
    return product(turn), np.stack(columns, axis=2)


# ---- Algorithm 1

Q_X_PI = rotation([1, 0, 0], np.pi)
TABLE_I = {  # t_task [m], q_task, q_inv
    "pour": ([0.01, 0, -0.05], quaternion_multiply(Q_X_PI, rotation([0, 0, 1], np.pi / 4)), Q_X_PI),
    "teleop": ([0, 0, 0], np.array([1.0, 0, 0, 0]), np.array([1.0, 0, 0, 0])),
    "mirror": ([0, 0, 0], Q_X_PI, Q_X_PI),
}
EQUATION_9 = rotation([1, 0, 0], -np.pi / 2)


class Algorithm1:
    """The paper's Algorithm 1, line by line, with motion scale 1 and no offset. Uses dqrobotics' own decompositional
    product."""

    def __init__(self, task: str, hand: np.ndarray, robot: np.ndarray, tracker_rotation: np.ndarray = EQUATION_9):
        self.task = task
        t_task, q_task, q_inv = TABLE_I[task]
        self.t_task, self.q_task = np.array(t_task), q_task
        self.hand_start = dq(hand)
        self.hand_start_torso = dq(tracker_rotation).conj() * self.hand_start
        self.virtual_start = self.hand_start_torso.conj() * dq(robot) * dq(q_inv)

    def target(self, hand: np.ndarray) -> np.ndarray:
        motion = self.hand_start.conj() * dq(hand)
        virtual = self.hand_start_torso * dqrobotics.dec_mult(self.virtual_start, motion)
        t_task = self.t_task
        if self.task == "mirror":
            moved = self.hand_start_torso * motion
            forward = moved.translation().vec3()[0] - self.hand_start_torso.translation().vec3()[0]
            t_task = np.array([0, 0, 2 * forward])
        return (virtual * dq(pose(self.q_task, t_task)).conj()).vec8()
