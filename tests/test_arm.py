"""Checks the kinematics of HOAP-3 and of arms with 1 to 8 joints against dqrobotics in double precision."""

from __future__ import annotations

import numpy as np
import oracle
import pytest
from comanip import core
from dqrobotics.robot_modeling import DQ_SerialManipulatorDH
from dqrobotics.robots import BarrettWamArmRobot, KukaLw4Robot

COUNT = 100_000
HOAP3 = "hoap3_right"


def assert_same(arm, q, expected_hand, expected_jacobian, tolerance=2e-6):
    hand, jacobian = core.forward_kinematics(arm, q), core.pose_jacobian(arm, q)
    sign = np.sign((hand * expected_hand).sum(axis=1, keepdims=True))
    assert np.abs(sign * hand - expected_hand).max() < tolerance
    assert np.abs(sign[..., None] * jacobian - expected_jacobian).max() < tolerance


def random_joints(rng, count: int, n: int, limit: float = np.pi) -> np.ndarray:
    return rng.uniform(-limit, limit, (count, n)).astype(np.float32)


def make_arm(fixed, axis, effector) -> core.Arm:
    n = len(fixed)
    return core.Arm(
        fixed.astype(np.float32),
        axis.astype(np.float32),
        np.full(n, -3, np.float32),
        np.full(n, 3, np.float32),
        np.full(n, 4, np.float32),
        effector.astype(np.float32),
    )


def test_hoap3_matches_dqrobotics_on_100_000_postures(rng):
    q = random_joints(rng, COUNT, 4)
    assert_same(HOAP3, q, *oracle.evaluate(oracle.hoap3(), q))


def test_hoap3_matches_the_manuals_chain(rng):
    q = random_joints(rng, 2000, 4)
    expected = np.array([oracle.hoap3_from_manual(row) for row in q])
    assert oracle.pose_distance(core.forward_kinematics(HOAP3, q), expected).max() < 2e-6


def test_hoap3_check_pose():
    """With the upper arm hanging and the forearm forward, the end effector is where the manual's lengths put it, with
    its z axis forward and its x axis up."""
    q = np.radians([[90, 0, 0, -90], [0, 0, 0, 0]]).astype(np.float32)
    check, straight = core.forward_kinematics(HOAP3, q)
    assert np.abs(oracle.translation(check) - [-0.035 + 0.171, -0.111, 0.125 - 0.111]).max() < 1e-6
    assert np.abs(oracle.rotate(check[:4], [0, 0, 1]) - [1, 0, 0]).max() < 1e-6
    assert np.abs(oracle.rotate(check[:4], [1, 0, 0]) - [0, 0, 1]).max() < 1e-6
    assert np.abs(oracle.translation(straight) - [-0.035 + 0.111 + 0.171, -0.111, 0.125]).max() < 1e-6


def test_hoap3_limits_are_the_manuals_minus_one_degree():
    arm = core.Arm.named(HOAP3)
    low, high = oracle.HOAP3_RANGE_DEG
    assert np.degrees(arm.position_min_rad) == pytest.approx(low + 1, abs=1e-4)
    assert np.degrees(arm.position_max_rad) == pytest.approx(high - 1, abs=1e-4)
    assert arm.velocity_max_radps == pytest.approx(np.full(4, 4.76))
    assert arm.jerk_max_radps3 == pytest.approx(np.full(4, 10_000))


def ur5() -> DQ_SerialManipulatorDH:
    """Returns the UR5 from Universal Robots' published table."""
    half = np.pi / 2
    return DQ_SerialManipulatorDH(
        np.array(
            [
                [0, 0, 0, 0, 0, 0],
                [0.089159, 0, 0, 0.10915, 0.09465, 0.0823],
                [0, -0.425, -0.39225, 0, 0, 0],
                [half, 0, 0, half, -half, 0],
                [0, 0, 0, 0, 0, 0],
            ]
        )
    )


@pytest.mark.parametrize("robot", [ur5, KukaLw4Robot.kinematics, BarrettWamArmRobot.kinematics])
def test_arms_of_6_and_7_joints(rng, robot):
    reference = robot()
    frames = (reference.get_base_frame().vec8(), reference.get_effector().vec8())
    dh = (reference.get_thetas(), reference.get_ds(), reference.get_as(), reference.get_alphas())
    fixed, effector = oracle.dh_chain(*dh, *frames)
    n = reference.get_dim_configuration_space()
    arm = make_arm(fixed, np.tile([0, 0, 1], (n, 1)), effector)
    q = random_joints(rng, COUNT // 4, n)
    assert_same(arm, q, *oracle.evaluate(reference, q))


@pytest.mark.parametrize("n", range(1, 9))
def test_any_arm_of_n_joints(rng, n):
    for _ in range(5):
        fixed = oracle.random_poses(rng, n, 0.2)
        axis = rng.normal(size=(n, 3))
        axis = (axis / np.linalg.norm(axis, axis=1, keepdims=True)).astype(np.float32)
        effector = oracle.random_poses(rng, 1, 0.2)[0]
        q = random_joints(rng, 500, n)
        assert_same(make_arm(fixed, axis, effector), q, *oracle.chain_kinematics(fixed, axis, effector, q))


@pytest.mark.parametrize("n", [3, 8])
def test_jacobian_is_the_derivative_of_the_forward_kinematics(rng, n):
    """Column i of the Jacobian equals the central difference (hand(q + h) - hand(q - h)) / 2h, where h is a step of
    joint i."""
    fixed, effector = oracle.random_poses(rng, n, 0.2), oracle.random_poses(rng, 1, 0.2)[0]
    arm = make_arm(fixed, np.tile([0, 1, 0], (n, 1)), effector)
    q = random_joints(rng, 200, n, 8.0)
    jacobian = core.pose_jacobian(arm, q)
    step = np.float32(2**-7)
    for i in range(n):
        offset = np.zeros(n, np.float32)
        offset[i] = step
        slope = (core.forward_kinematics(arm, q + offset) - core.forward_kinematics(arm, q - offset)) / (2 * step)
        assert np.abs(slope - jacobian[:, :, i]).max() < 1e-4


def test_hand_is_unit_and_jacobian_tangent_to_the_unit_poses(rng):
    """The primary part P and the dual part D of every pose satisfy |P| = 1 and P . D = 0. Each column of the Jacobian
    preserves both properties to first order."""
    q = random_joints(rng, COUNT, 4)
    hand, jacobian = core.forward_kinematics(HOAP3, q).astype(float), core.pose_jacobian(HOAP3, q).astype(float)
    assert np.abs(np.linalg.norm(hand[:, :4], axis=1) - 1).max() < 1e-6
    assert np.abs(np.einsum("ik,ikj->ij", hand[:, :4], jacobian[:, :4])).max() < 1e-6
    swapped = np.concatenate([hand[:, 4:], hand[:, :4]], axis=1)
    assert np.abs(np.einsum("ik,ikj->ij", swapped, jacobian)).max() < 1e-6


def test_the_defaults_of_core_and_description_are_equal():
    """The two defaults are defined in packages that cannot import each other, so neither can be derived from the
    other."""
    from comanip_dev.arms.description import DRIVE_LAG_DEFAULT_S, JERK_DEFAULT_RADPS3

    arm = make_arm(np.eye(1, 8), np.eye(1, 3), np.eye(1, 8)[0])
    assert arm.jerk_max_radps3.tolist() == [JERK_DEFAULT_RADPS3]
    assert arm.drive_lag_max_s == pytest.approx(DRIVE_LAG_DEFAULT_S)
    assert core.Arm.named(HOAP3).drive_lag_max_s == pytest.approx(0.013)
