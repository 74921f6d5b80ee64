"""Checks control law (4) against numpy and dqrobotics in double precision, including the double cover and
singularities."""

from __future__ import annotations

import numpy as np
import oracle
import pytest
from comanip import core
from comanip._core import ffi, lib
from dqrobotics.robot_control import ControlObjective, DQ_PseudoinverseController

HOAP3 = "hoap3_right"
COUNT = 100_000
WEIGHTED = np.array([0.05] * 4 + [100] * 4, np.float32)


def postures(rng, count: int) -> np.ndarray:
    arm = core.Arm.named(HOAP3)
    return rng.uniform(arm.position_min_rad, arm.position_max_rad, (count, 4)).astype(np.float32)


def tolerance(weight, damping: float) -> float:
    """Returns the precision that float32 can achieve on this arm. The condition number of the normal equations grows as
    1/lambda."""
    return max(5e-5, 5e-8 * max(4.0, float(np.max(weight))) / damping)


@pytest.mark.parametrize("error_frame", ["torso", "target"])
@pytest.mark.parametrize(
    ("gain", "weight"),
    [
        (4.0, None),
        (100.0, 1.0),
        (np.array([4] * 4 + [400] * 4, np.float32), None),
        (np.arange(1, 9, dtype=np.float32), np.array([3, 1, 4, 1, 5, 9, 2, 6], np.float32)),
        (100.0, 10.0),
        (np.array([1] * 4 + [100] * 4, np.float32), 100.0),
        (100.0, WEIGHTED),
        (np.array([1] * 4 + [100] * 4, np.float32), WEIGHTED),
    ],
    ids=[
        "paper",
        "scalar weight",
        "gain",
        "both",
        "weight 10",
        "weight 100",
        "position weighted",
        "default weight, gain",
    ],
)
def test_law_on_100_000_random_inputs(rng, error_frame, gain, weight):
    q, target = postures(rng, COUNT), oracle.random_poses(rng, COUNT, 0.3)
    hand, jacobian = oracle.evaluate(oracle.hoap3(), q)
    w = 1.0 if weight is None else weight
    for batch, damping in zip(np.array_split(np.arange(COUNT), 10), np.geomspace(1e-4, 1e-2, 10), strict=True):
        u = core.joint_velocity(HOAP3, q[batch], target[batch], gain, damping, error_frame, weight)
        reference = (jacobian[batch], hand[batch], target[batch].astype(float))
        expected = oracle.law(*reference, gain, w, np.float32(damping), error_frame)
        scale = np.maximum(max(1.0, np.max(gain) / 10), np.linalg.norm(expected, axis=1))
        assert (np.abs(u - expected).max(axis=1) / scale).max() < tolerance(w, damping)


@pytest.mark.parametrize("error_frame", ["torso", "target"])
@pytest.mark.parametrize("weight", [10.0, 100.0])
def test_law_where_the_normal_equations_are_worst_conditioned(rng, error_frame, weight):
    """The law stays within the tolerance for a large uniform weight, for which the normal equations are worst
    conditioned, and for each damping lambda. Without iterative refinement it would exceed the tolerance. Errors are
    relative to the largest component of u."""
    gain = np.array([1] * 4 + [100] * 4, np.float32)
    q, target = postures(rng, COUNT), oracle.random_poses(rng, COUNT, 0.3)
    hand, jacobian = oracle.evaluate(oracle.hoap3(), q)
    for damping in (1e-4, 1e-3, 1e-2):
        u = core.joint_velocity(HOAP3, q, target, gain, damping, error_frame, weight)
        expected = oracle.law(jacobian, hand, target.astype(float), gain, weight, np.float32(damping), error_frame)
        scale = np.maximum(np.max(gain) / 10, np.abs(expected).max(axis=1))
        assert (np.abs(u - expected).max(axis=1) / scale).max() < tolerance(weight, damping)


@pytest.mark.parametrize("error_frame", ["torso", "target"])
@pytest.mark.parametrize("weight", [(0.01, 100), (1, 1), (1, 4), (25, 100), (0, 100)], ids=str)
def test_the_fast_law_keeps_the_tolerance_up_to_its_bounds(rng, error_frame, weight):
    """The fast (isotropic) law stays within the tolerance wherever differential_ik_prepare() allows it. The default
    parameters are among these cases."""
    weight = np.repeat(weight, 4).astype(np.float32)
    q, target = postures(rng, COUNT // 4), oracle.random_poses(rng, COUNT // 4, 0.3)
    hand, jacobian = oracle.evaluate(oracle.hoap3(), q)
    for damping in np.geomspace(1.0001e-5, 1e-2, 4) * max(weight):
        config = ffi.new(
            "differential_ik_config_t *", {"gain_per_s": [35.0] * 8, "weight": weight.tolist(), "damping": damping}
        )
        lib.differential_ik_prepare(config)
        assert config.isotropic.applies
        u = core.joint_velocity(HOAP3, q, target, 35.0, damping, error_frame, weight)
        expected = oracle.law(jacobian, hand, target.astype(float), 35.0, weight, np.float32(damping), error_frame)
        scale = np.maximum(3.5, np.linalg.norm(expected, axis=1))
        assert (np.abs(u - expected).max(axis=1) / scale).max() < tolerance(weight, damping)


def test_the_papers_law_matches_dqrobotics_damped_controller(rng):
    """The law agrees with dqrobotics' controller. The paper's lambda is the square of dqrobotics' damping."""
    robot, gain = oracle.hoap3(), 4.0
    for damping in (1e-4, 1e-3, 1e-2):
        controller = DQ_PseudoinverseController(robot)
        controller.set_control_objective(ControlObjective.Pose)
        controller.set_gain(gain)
        controller.set_damping(np.sqrt(damping))
        q, target = postures(rng, 300), oracle.random_poses(rng, 300, 0.3)
        hand = oracle.evaluate(robot, q)[0]
        sign = np.where((hand[:, :4] * target[:, :4]).sum(axis=1, keepdims=True) < 0, -1, 1)
        nearest = oracle.unit(sign * target)
        expected = np.array(
            [controller.compute_setpoint_control_signal(*pair) for pair in zip(q.astype(float), nearest, strict=True)]
        )
        u = core.joint_velocity(HOAP3, q, target, gain, damping)
        error = np.abs(u - expected).max(axis=1) / np.maximum(1, np.linalg.norm(expected, axis=1))
        assert error.max() < tolerance(1.0, damping)


@pytest.mark.parametrize("error_frame", ["torso", "target"])
@pytest.mark.parametrize("n", range(1, 9))
def test_law_for_arms_of_any_number_of_joints(rng, n, error_frame):
    fixed, effector = oracle.random_poses(rng, n, 0.2), oracle.random_poses(rng, 1, 0.2)[0]
    axis = np.tile(np.array([0, 0, 1], np.float32), (n, 1))
    limits = np.full(n, 3, np.float32)
    arm = core.Arm(fixed, axis, -limits, limits, limits, effector)
    q, target = rng.uniform(-3, 3, (2000, n)).astype(np.float32), oracle.random_poses(rng, 2000, 0.5)
    hand, jacobian = oracle.chain_kinematics(fixed, axis, effector, q)
    expected = oracle.law(jacobian, hand, target.astype(float), 4.0, 1.0, 1e-2, error_frame)
    u = core.joint_velocity(arm, q, target, 4.0, 0.01, error_frame)
    assert (np.abs(u - expected).max(axis=1) / np.maximum(1, np.linalg.norm(expected, axis=1))).max() < 2e-4


@pytest.mark.parametrize("error_frame", ["torso", "target"])
def test_double_cover_minus_target_is_the_same_target(rng, error_frame):
    q, target = postures(rng, COUNT), oracle.random_poses(rng, COUNT, 0.3)
    one, other = (core.joint_velocity(HOAP3, q, t, 100.0, 1e-3, error_frame, WEIGHTED) for t in (target, -target))
    assert np.array_equal(one, other)


@pytest.mark.parametrize("error_frame", ["torso", "target"])
def test_no_error_no_velocity(rng, error_frame):
    """At zero error, neither sign of the target causes a motion. If the law simply subtracted components, the target
    -x, which is the same pose, would command several rad/s."""
    q = postures(rng, 1000)
    hand = core.forward_kinematics(HOAP3, q)
    for target in (hand, -hand):
        assert np.abs(core.joint_velocity(HOAP3, q, target, 4.0, 1e-3, error_frame)).max() < 1e-3


def singular_postures(rng) -> np.ndarray:
    """Returns postures with a straight elbow, with the upper arm along the pitch axis (roll -90 deg), or with
    both. Some postures are exactly singular, others lie at various distances from the singularity."""
    base = np.radians(
        [[0, 0, 0, 0], [90, 0, 0, 0], [90, -30, 20, 0], [10, -90, 0, -60], [90, -90, 0, -90], [0, -90, 0, 0]]
    )
    near = np.repeat(base, 2000, axis=0)
    near += 10.0 ** rng.uniform(-9, -2, (len(near), 1)) * rng.normal(size=near.shape)
    return np.vstack([np.repeat(base, 200, axis=0), near]).astype(np.float32)


@pytest.mark.parametrize("error_frame", ["torso", "target"])
@pytest.mark.parametrize("weight", [None, WEIGHTED], ids=["paper", "weighted"])
def test_zero_damping_at_singular_postures(rng, error_frame, weight):
    """The joint velocities are finite and bounded, and the end effector moves no faster than the error demands, because
    J u is a projection of K e."""
    gain = 4.0
    q = singular_postures(rng)
    target = oracle.random_poses(rng, len(q), 0.3)
    u = core.joint_velocity(HOAP3, q, target, gain, 0.0, error_frame, weight)
    assert np.isfinite(u).all()
    assert np.abs(u).max() < 2000 * gain  # 2000 is about 1 / sqrt(float32's resolution)
    root = np.sqrt(np.broadcast_to(1.0 if weight is None else weight, 8))
    hand, jacobian = oracle.evaluate(oracle.hoap3(), q)
    target = np.where((hand[:, :4] * target[:, :4]).sum(axis=1, keepdims=True) < 0, -1, 1) * target.astype(float)
    motion, error = (jacobian @ u[..., None])[..., 0], target - hand
    if error_frame == "target":
        motion, error = (oracle.multiply(oracle.conjugate(target), x) for x in (motion, error))
    demanded = gain * np.linalg.norm(root * error, axis=1)
    assert (np.linalg.norm(root * motion, axis=1) < 1.1 * demanded).all()


def test_zero_damping_with_more_joints_than_degrees_of_freedom(rng):
    """For an arm with 8 joints for 6 degrees of freedom, J^T J is always singular, yet the end effector moves as
    demanded."""
    fixed, effector = oracle.random_poses(rng, 8, 0.3), oracle.random_poses(rng, 1, 0.3)[0]
    axis = np.tile(np.array([0, 0, 1], np.float32), (8, 1))
    limits = np.full(8, 3, np.float32)
    arm = core.Arm(fixed, axis, -limits, limits, limits, effector)
    q = rng.uniform(-3, 3, (500, 8)).astype(np.float32)
    goal = core.forward_kinematics(arm, q + np.float32(0.01))
    u = core.joint_velocity(arm, q, goal, 4.0, 0.0)
    hand, jacobian = oracle.chain_kinematics(fixed, axis, effector, q)
    expected = 4.0 * (goal * np.sign((goal * hand).sum(axis=1, keepdims=True)) - hand)
    assert np.isfinite(u).all()
    assert np.abs((jacobian @ u[..., None])[..., 0] - expected).max() < 0.02


def test_without_weights_nothing_moves(rng):
    u = core.joint_velocity(HOAP3, postures(rng, 10), oracle.random_poses(rng, 10, 0.3), 4.0, 0.0, weight=0.0)
    assert np.array_equal(u, np.zeros((10, 4)))


def settle(start_deg, displacement_m, gain, damping, error_frame, weight) -> tuple[float, float]:
    """Returns the steady-state error [mm, deg] of the mirrored target, without delays, after the hand has been moved by
    a displacement in torso axes."""
    q = np.radians([start_deg]).astype(np.float32)
    start = core.forward_kinematics(HOAP3, q)[0]
    cooperation = core.Cooperation("mirror", tracker_rotation=np.array([1, 0, 0, 0], np.float32))
    hand = oracle.pose([1, 0, 0, 0], [0, 0, 0]).astype(np.float32)
    cooperation.start(hand, start)
    target = cooperation.target(oracle.pose([1, 0, 0, 0], displacement_m).astype(np.float32))[None]
    step = 0.5 / np.max(gain) / (1 if np.ndim(gain) == 0 else 10)
    for _ in range(40_000):
        u = core.joint_velocity(HOAP3, q, target, gain, damping, error_frame, weight)
        q = (q + np.clip(u * step, -0.05, 0.05)).astype(np.float32)
        if np.abs(u).max() < 1e-4:
            break
    reached = core.forward_kinematics(HOAP3, q)
    position = np.linalg.norm(oracle.translation(reached) - oracle.translation(target))
    return 1e3 * position, np.degrees(oracle.rotation_angle(reached, target)[0])


@pytest.mark.parametrize("displacement_m", [[0.03, 0, 0], [0, 0.03, 0], [0, 0, 0.03]])
def test_error_at_the_target_makes_a_4_joint_arm_usable(displacement_m):
    """If the error is computed in the target's frame, the orientation error that 4 joints cannot correct leaves the
    position error below 0.7 mm. In the torso frame, it causes a position error of more than 25 mm after a displacement
    along y or z, and of more than 3 mm along x."""
    start = (90, -5, 0, -90)
    torso, _ = settle(start, displacement_m, 4.0, 1e-4, "torso", None)
    target, turned = settle(start, displacement_m, 100.0, 1e-3, "target", WEIGHTED)
    assert target < 0.7
    assert turned < 10.5
    assert torso > 3.0 if displacement_m[0] else torso > 25.0
