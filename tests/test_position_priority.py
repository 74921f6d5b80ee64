"""position_priority() agrees with its equations in double precision on dqrobotics' kinematics, and descends its
potential."""

from __future__ import annotations

import numpy as np
import oracle
import pytest
from comanip import core
from comanip._core import ffi, lib

JOINTS = 4
# lower and upper end of each joint's usable range, one degree inside the stops
RANGE = np.radians(oracle.HOAP3_RANGE_DEG + np.array([[1], [-1]])).T
GAIN, WEIGHT = 35.0, 1.5e-5
ERROR_MAX_M, MARGIN_RAD, STIFFNESS, DAMPING_M2, CURVATURE = 0.015, 0.6, 5.0, 1e-5, 0.25
TASK_DAMPING_M2, TASK_FLOOR_M2 = 3e-4, 1e-5
MARGIN_TURN_RAD4 = 0.073


def hand_at(q: np.ndarray) -> np.ndarray:
    return oracle.evaluate(oracle.hoap3(), np.atleast_2d(q))[0][0]


def geometric_jacobian(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns the end effector's Jacobians of position and of rotation (angular velocity per joint velocity), (3, 4)
    each, in torso axes, by central differences of dqrobotics' kinematics."""
    h = 1e-5
    linear, angular = np.empty((3, JOINTS)), np.empty((3, JOINTS))
    for i in range(JOINTS):
        ahead, behind = hand_at(q + h * np.eye(JOINTS)[i]), hand_at(q - h * np.eye(JOINTS)[i])
        linear[:, i] = (oracle.translation(ahead) - oracle.translation(behind)) / (2 * h)
        turn = oracle.quaternion_multiply(ahead[:4], oracle.quaternion_conjugate(behind[:4]))
        angular[:, i] = np.sign(turn[0]) * turn[1:] / h
    return linear, angular


def error(q: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns the translation to the target, and twice the vector part of the rotation to it, in torso axes."""
    hand = hand_at(q)
    turn = oracle.quaternion_multiply(target[:4], oracle.quaternion_conjugate(hand[:4]))
    return oracle.translation(target) - oracle.translation(hand), 2 * turn[1:] * (1 if turn[0] >= 0 else -1)


def out_of_margin(q: np.ndarray) -> np.ndarray:
    return np.maximum(MARGIN_RAD - (q - RANGE[:, 0]), 0) - np.maximum(MARGIN_RAD - (RANGE[:, 1] - q), 0)


def stiffness(turn: np.ndarray) -> float:
    return STIFFNESS * (turn @ turn) ** 2 / ((turn @ turn) ** 2 + MARGIN_TURN_RAD4)


def potential(q: np.ndarray, target: np.ndarray, k: float) -> float:
    way, turn = error(q, target)
    distance = np.linalg.norm(way)
    position = distance**2 / 2 if distance <= ERROR_MAX_M else ERROR_MAX_M * (distance - ERROR_MAX_M / 2)
    cosine_half = np.sqrt(
        1 - (turn @ turn) / 4
    )  # the gradient of 4 (1 - cos(angle / 2)) with respect to the rotation is `turn`, up to its sign
    return position + WEIGHT * (4 * (1 - cosine_half) + k / 2 * (out_of_margin(q) @ out_of_margin(q)))


def law(q, target, motion=(0.0,) * 6, at_limit=(0, 0), written_out=False) -> tuple[np.ndarray, np.ndarray, float]:
    arm = core.Arm.named("hoap3_right")
    position = ffi.new("float[]", [float(x) for x in q])
    config = ffi.new("position_priority_config_t *", {"gain_per_s": GAIN, "orientation_weight_m2": WEIGHT})
    goal, twist = ffi.new("pose_t *"), ffi.new("twist_t *")
    goal.rotation, goal.translation_m = (
        dict(zip("wxyz", map(float, target[:4]))),
        dict(zip("xyz", map(float, oracle.translation(target)))),
    )
    twist.velocity_mps, twist.angular_velocity_radps = (
        dict(zip("xyz", map(float, part))) for part in np.split(np.asarray(motion), 2)
    )
    request = ffi.new("position_priority_request_t *", {"position_rad": position, "target": goal, "motion": twist})
    request.at_limit = {"lower": at_limit[0], "upper": at_limit[1]}
    for_error, for_motion = ffi.new("float[8]"), ffi.new("float[8]")
    distance = (arm.ik.position_priority if written_out else lib.position_priority)(
        arm.table, config, request, for_error, for_motion
    )
    return np.array(list(for_error)[:JOINTS]), np.array(list(for_motion)[:JOINTS]), distance


def matrix(q: np.ndarray, target: np.ndarray) -> np.ndarray:
    linear, angular = geometric_jacobian(q)
    way, turn = error(q, target)
    way = way * min(1, ERROR_MAX_M / np.linalg.norm(way))
    task = np.eye(3) + TASK_DAMPING_M2 * np.linalg.inv(linear @ linear.T + TASK_FLOOR_M2 * np.eye(3))
    normal = linear.T @ task @ linear + WEIGHT * angular.T @ angular
    for i in range(JOINTS):
        bound = sum(abs(np.cross(angular[:, min(i, j)], way) @ linear[:, max(i, j)]) for j in range(JOINTS))
        normal[i, i] += DAMPING_M2 + CURVATURE * bound + WEIGHT * stiffness(turn) * (out_of_margin(q)[i] != 0)
    return normal


def cases(rng, count: int):
    for _ in range(count):
        q = rng.uniform(*RANGE.T)
        near = oracle.rotation(rng.normal(size=3), rng.uniform(0, 3))
        hand = hand_at(q)
        reach = 10 ** rng.uniform(-3.5, 0)
        offset = rng.normal(size=3)
        yield (
            q,
            oracle.pose(
                oracle.quaternion_multiply(near, hand[:4]),
                oracle.translation(hand) + reach * offset / np.linalg.norm(offset),
            ),
        )


@pytest.mark.parametrize("written_out", [False, True])
def test_both_velocities_match_the_equations(rng, written_out):
    for q, target in cases(rng, 200):
        linear, angular = geometric_jacobian(q)
        way, turn = error(q, target)
        motion = np.r_[rng.normal(0, 0.3, 3), rng.normal(0, 1, 3)]
        capped = way * min(1, ERROR_MAX_M / np.linalg.norm(way))
        normal = matrix(q, target)
        pull = GAIN * (linear.T @ capped + WEIGHT * (angular.T @ turn + stiffness(turn) * out_of_margin(q)))
        carried = linear.T @ motion[:3] + WEIGHT * angular.T @ motion[3:]
        for_error, for_motion, distance = law(q, target, motion, written_out=written_out)
        assert distance == pytest.approx(np.linalg.norm(way), abs=1e-6)
        for found, right_hand_side in ((for_error, pull), (for_motion, carried)):
            expected = np.linalg.solve(normal, right_hand_side)
            assert np.abs(found - expected).max() < 5e-3 * max(1, np.abs(expected).max()), (q, target)


@pytest.mark.parametrize("written_out", [False, True])
def test_it_descends_the_potential_given_in_its_header(rng, written_out):
    """The joint velocities u obey N u = -K grad V. Here the gradient of the potential V is computed from differences of
    V, and N is positive definite. Therefore V never grows, and the arm comes to rest."""
    for q, target in cases(rng, 200):
        h, k = 1e-6, stiffness(error(q, target)[1])
        gradient = np.array(
            [(potential(q + h * e, target, k) - potential(q - h * e, target, k)) / (2 * h) for e in np.eye(JOINTS)]
        )
        normal = matrix(q, target)
        for_error, _, _ = law(q, target, written_out=written_out)
        assert np.linalg.eigvalsh(normal).min() > 0
        expected = np.linalg.solve(normal, -GAIN * gradient)
        assert np.abs(for_error - expected).max() < 1e-2 * max(1, np.abs(expected).max())
        assert for_error @ gradient <= 1e-7


@pytest.mark.parametrize("written_out", [False, True])
def test_no_joint_at_a_limit_moves_past_it(rng, written_out):
    held = 0
    for q, target in cases(rng, 200):
        lower, upper = int(rng.integers(16)), int(rng.integers(16))
        lower &= ~upper
        for_error, for_motion, _ = law(
            q, target, np.r_[rng.normal(0, 0.3, 3), rng.normal(0, 1, 3)], (lower, upper), written_out
        )
        u = for_error + for_motion
        for i in range(JOINTS):
            assert not (lower >> i & 1 and u[i] < 0) and not (upper >> i & 1 and u[i] > 0)
            held += u[i] == 0
    assert held > 50


@pytest.mark.parametrize("written_out", [False, True])
def test_either_sign_of_the_target_is_the_same_pose(rng, written_out):
    for q, target in cases(rng, 20):
        assert (law(q, target, written_out=written_out)[0] == law(q, -target, written_out=written_out)[0]).all()


@pytest.mark.parametrize("written_out", [False, True])
def test_a_doubly_singular_posture_gives_a_bounded_velocity(written_out):
    """The velocity is bounded when the arm is fully stretched and the end effector lies on the first joint's axis, so
    that the end effector can move in only one of the three directions."""
    for q in (
        [0.3, 0.0, 0.0, 0.0],
        [0.3, -1.6580, 0.0, 0.0],
        [1.0, -np.pi / 2, 0.5, 0.0],
        [1.0, -np.pi / 2, 0.5, -1e-3],
    ):
        hand = hand_at(np.array(q))
        for way in np.vstack([np.eye(3), -np.eye(3)]) * 0.01:
            target = oracle.pose(hand[:4], oracle.translation(hand) + way)
            for_error, for_motion, _ = law(np.array(q), target, np.r_[30 * way, 0, 0, 0], written_out=written_out)
            assert np.isfinite(for_error).all() and np.abs(for_error).max() < 30 and np.abs(for_motion).max() < 60
            linear, _ = geometric_jacobian(np.array(q))
            assert (linear @ for_error) @ way > -1e-4  # does not move away from the target
