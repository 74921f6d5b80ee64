"""Checks the firmware's Algorithm 1 against the paper's, evaluated line by line with dqrobotics, and checks the paper's
claims about it."""

from __future__ import annotations

import numpy as np
import oracle
import pytest
from comanip import core
from comanip._core import ffi, lib

TASKS = ["pour", "teleop", "mirror"]
CHECK_POSTURE = np.radians([[90, 0, 0, -90]]).astype(np.float32)  # end effector z forward, x up
ONE = np.array([1.0, 0, 0, 0])


def robot_at_check_posture() -> np.ndarray:
    return core.forward_kinematics("hoap3_right", CHECK_POSTURE)[0]


def motion(rng, steps: int = 50) -> np.ndarray:
    """Returns a random motion of the hand in the tracker frame, with translation and rotation."""
    r = oracle.random_rotations(rng, 1)[0]
    t = rng.uniform(-1, 1, 3)
    rows = []
    for _ in range(steps):
        rows.append(oracle.pose(r, t))
        r = oracle.quaternion_multiply(oracle.rotation(rng.normal(size=3), rng.uniform(0, 0.2)), r)
        t = t + rng.normal(scale=0.01, size=3)
    return np.array(rows).astype(np.float32)


def follow(task: str, hands: np.ndarray, robot: np.ndarray, **options) -> np.ndarray:
    cooperation = core.Cooperation(task, **options)
    cooperation.start(hands[0].astype(np.float32), robot.astype(np.float32))
    return np.array([cooperation.target(hand) for hand in hands.astype(np.float32)])


def displacement(targets: np.ndarray) -> np.ndarray:
    return oracle.translation(targets[-1]) - oracle.translation(targets[0])


def hand_in_tracker(rotation, translation, tracker_rotation=oracle.EQUATION_9) -> np.ndarray:
    """Returns the pose that the tracker measures for a hand given in torso axes."""
    return oracle.pose(
        oracle.quaternion_multiply(tracker_rotation, np.asarray(rotation, float)),
        oracle.rotate(tracker_rotation, translation),
    ).astype(np.float32)


# ---- the algorithm


@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize("placed", ["as in (9)", "anyhow"])
def test_targets_are_algorithm_1(rng, task, placed):
    for _ in range(40):
        hands, robot = motion(rng), oracle.random_poses(rng, 1, 0.3)[0]
        options = (
            {} if placed == "as in (9)" else {"tracker_rotation": oracle.random_rotations(rng, 1)[0].astype(np.float32)}
        )
        reference = oracle.Algorithm1(task, hands[0], robot, options.get("tracker_rotation", oracle.EQUATION_9))
        expected = np.array([reference.target(hand) for hand in hands])
        assert oracle.pose_distance(follow(task, hands, robot, **options), expected).max() < 3e-6


@pytest.mark.parametrize("task", TASKS)
def test_virtual_hand_in_closed_form(rng, task):
    """The virtual hand has the position p_R0 + offset + s R_ET^T (p_H - p_H0) and the rotation dR R_R0 R(q_inv). Index
    0 means at the start, s is the motion scale, R_ET the tracker's rotation, and dR the hand's rotation since the
    start. The target is the virtual hand times the conjugate of the task's relation."""
    for _ in range(40):
        hands, robot = motion(rng).astype(float), oracle.random_poses(rng, 1, 0.3)[0].astype(float)
        scale, offset = float(rng.uniform(0.1, 3)), rng.uniform(-0.3, 0.3, 3).astype(np.float32)
        targets = follow(task, hands, robot, scale=scale, start_offset=offset)
        torso_from_tracker = oracle.quaternion_conjugate(oracle.EQUATION_9)
        moved = scale * oracle.rotate(torso_from_tracker, oracle.translation(hands) - oracle.translation(hands[0]))
        in_torso = oracle.quaternion_multiply(np.tile(torso_from_tracker, (len(hands), 1)), hands[:, :4])
        turned = oracle.quaternion_multiply(in_torso, oracle.quaternion_conjugate(in_torso[:1]))
        t_task, q_task, q_inv = oracle.TABLE_I[task]
        virtual = oracle.pose(
            oracle.quaternion_multiply(turned, oracle.quaternion_multiply(robot[:4], q_inv)[None]),
            oracle.translation(robot) + offset + moved,
        )
        relation = oracle.pose(
            np.tile(q_task, (len(hands), 1)), np.array(t_task) + (task == "mirror") * 2 * moved[:, :1] * [0, 0, 1]
        )
        expected = oracle.multiply(virtual, oracle.conjugate(relation))
        assert oracle.pose_distance(targets, expected).max() < 3e-6


def test_default_tracker_rotation_is_equation_9(rng):
    hands, robot = motion(rng), robot_at_check_posture()
    explicit = follow("mirror", hands, robot, tracker_rotation=oracle.EQUATION_9.astype(np.float32))
    assert np.abs(follow("mirror", hands, robot) - explicit).max() < 1e-6


def test_targets_are_unit(rng):
    for task in TASKS:
        targets = follow(task, motion(rng, 500), robot_at_check_posture())
        assert np.abs(targets - oracle.unit(targets)).max() < 1e-6


# ---- claim 1: placement invariance


@pytest.mark.parametrize("task", TASKS)
def test_the_tracker_may_be_placed_anywhere(rng, task):
    hands, robot = motion(rng), robot_at_check_posture()
    here = follow(task, hands, robot)
    for _ in range(50):
        there = oracle.multiply(oracle.pose(ONE, rng.uniform(-3, 3, 3)), hands.astype(float))
        assert oracle.pose_distance(follow(task, there, robot), here).max() < 1e-5


@pytest.mark.parametrize("task", TASKS)
def test_the_marker_may_be_turned_on_the_hand(rng, task):
    hands, robot = motion(rng), robot_at_check_posture()
    for turn in oracle.random_rotations(rng, 50):
        turned = oracle.multiply(hands.astype(float), oracle.pose(turn, np.zeros(3)))
        assert oracle.pose_distance(follow(task, turned, robot), follow(task, hands, robot)).max() < 3e-6


@pytest.mark.parametrize("task", TASKS)
def test_a_turned_tracker_needs_its_rotation_and_then_changes_nothing(rng, task):
    hands, robot = motion(rng), robot_at_check_posture()
    turn = oracle.rotation([1, 2, 3], 0.5)
    turned = oracle.multiply(oracle.pose(turn, np.zeros(3)), hands.astype(float))
    calibration = oracle.quaternion_multiply(turn, oracle.EQUATION_9).astype(np.float32)
    same = follow(task, hands, robot)
    assert oracle.pose_distance(follow(task, turned, robot, tracker_rotation=calibration), same).max() < 3e-6
    assert oracle.pose_distance(follow(task, turned, robot), same).max() > 1e-3


@pytest.mark.parametrize("task", TASKS)
def test_a_lever_arm_of_the_marker_matters_once_the_hand_turns(rng, task):
    robot, lever = robot_at_check_posture(), oracle.pose(ONE, [0.1, 0, 0])
    turning = np.array([oracle.pose(oracle.rotation([0, 0, 1], a), [0.2, 0, 0]) for a in np.linspace(0, 0.5, 5)])
    off = follow(task, oracle.multiply(turning, lever), robot)
    assert oracle.pose_distance(off, follow(task, turning, robot)).max() > 1e-2


# ---- claim 2: the start


def test_teleoperation_starts_at_the_robots_pose(rng):
    for robot in oracle.random_poses(rng, 200, 0.3):
        assert oracle.pose_distance(follow("teleop", motion(rng, 1), robot)[0], robot) < 1e-6


def test_mirroring_starts_at_the_robots_pose(rng):
    for robot in oracle.random_poses(rng, 200, 0.3):
        assert oracle.pose_distance(follow("mirror", motion(rng, 1), robot)[0], robot) < 1e-6


def test_pouring_starts_rolled_by_45_degrees_about_the_robots_own_z(rng):
    """At the start, the target is rolled by 45 degrees from the end effector's pose. In the target's axes, the end
    effector is at (0.01, 0, -0.05) m."""
    for robot in oracle.random_poses(rng, 200, 0.3).astype(float):
        target = follow("pour", motion(rng, 1), robot)[0]
        roll = oracle.quaternion_multiply(oracle.quaternion_conjugate(robot[:4]), target[:4])
        expected = oracle.rotation([0, 0, 1], np.pi / 4)
        assert min(np.abs(roll - expected).max(), np.abs(roll + expected).max()) < 1e-6
        in_target = oracle.rotate(
            oracle.quaternion_conjugate(target[:4].astype(float)),
            oracle.translation(robot) - oracle.translation(target),
        )
        assert np.abs(in_target - [0.01, 0, -0.05]).max() < 1e-6


# ---- claim 3: the mirror


@pytest.mark.parametrize("scale", [1.0, 0.5, 2.0])
def test_mirror_signs_and_scale(rng, scale):
    """With the end effector's z axis along +x of the torso, a displacement (dx, dy, dz) becomes (-dx, dy, dz),
    multiplied by the scale."""
    robot = robot_at_check_posture()
    for d in rng.uniform(-0.05, 0.05, (50, 3)):
        hands = np.array([hand_in_tracker(ONE, [0.4, 0.1, 0.2] + factor * d) for factor in (0, 1)])
        assert np.abs(displacement(follow("mirror", hands, robot, scale=scale)) - scale * d * [-1, 1, 1]).max() < 1e-6


def test_mirror_needs_the_hands_z_axis_forward():
    """With the end effector's z axis along -x of the torso, a displacement dx becomes 3 dx instead of -dx."""
    backwards = oracle.pose(oracle.rotation([0, 1, 0], -np.pi / 2), [0.1, -0.1, 0])
    hands = np.array([hand_in_tracker(ONE, [x, 0, 0]) for x in (0, 0.02)])
    assert np.abs(displacement(follow("mirror", hands, backwards)) - [0.06, 0, 0]).max() < 1e-6


@pytest.mark.parametrize("task", TASKS)
def test_scale_does_not_change_rotations(rng, task):
    hands, robot = motion(rng), robot_at_check_posture()
    scaled, plain = (follow(task, hands, robot, scale=s) for s in (0.3, 1.0))
    assert oracle.rotation_angle(scaled, plain).max() < 2e-6


@pytest.mark.parametrize("task", ["pour", "teleop"])
def test_the_other_tasks_follow_the_hand(task):
    hands = np.array([hand_in_tracker(ONE, d) for d in ([0, 0, 0], [0.02, -0.03, 0.01])])
    assert np.abs(displacement(follow(task, hands, robot_at_check_posture())) - [0.02, -0.03, 0.01]).max() < 1e-6


# ---- the double cover


@pytest.mark.parametrize("task", TASKS)
def test_sign_flips_in_the_stream_change_no_output(rng, task):
    hands, robot = motion(rng, 200), robot_at_check_posture()
    signs = np.where(rng.random((len(hands), 1)) < 0.5, -1, 1).astype(np.float32)
    signs[0] = 1
    steady, flipped = follow(task, hands, robot), follow(task, hands * signs, robot)
    q = np.repeat(CHECK_POSTURE, len(hands), axis=0)
    commands = [core.joint_velocity("hoap3_right", q, t, 100.0, 1e-3, "target") for t in (steady, flipped)]
    assert np.array_equal(*commands)
    assert np.array_equal(np.abs(steady), np.abs(flipped))


# ---- the latch


def mirrored_to_30_mm(latch: str):
    cooperation, robot = core.Cooperation("mirror", latch=latch), robot_at_check_posture()
    cooperation.start(hand_in_tracker(ONE, [0, 0, 0]), robot)
    return cooperation, cooperation.target(hand_in_tracker(ONE, [-0.03, 0.01, 0.02]))


def test_latch_commanded_makes_no_step_and_ends_the_mirroring():
    cooperation, before = mirrored_to_30_mm("commanded")
    cooperation.grasp()
    after = cooperation.target(hand_in_tracker(ONE, [-0.03, 0.01, 0.02]))
    moved = cooperation.target(hand_in_tracker(ONE, [-0.01, 0.01, 0.02]))
    assert np.abs(after - before).max() < 1e-6
    assert np.abs(oracle.translation(moved) - oracle.translation(after) - [0.02, 0, 0]).max() < 1e-6


def test_latch_measured_keeps_the_relation_being_performed():
    cooperation, before = mirrored_to_30_mm("measured")
    measured = oracle.multiply(
        before.astype(float), oracle.pose(oracle.rotation([1, 1, 0], 0.05), [0.002, 0.001, -0.003])
    )
    cooperation.grasp(measured.astype(np.float32))
    after = cooperation.target(hand_in_tracker(ONE, [-0.03, 0.01, 0.02]))
    moved = cooperation.target(hand_in_tracker(ONE, [-0.01, 0.01, 0.02]))
    assert oracle.pose_distance(after, measured) < 1e-6
    assert np.abs(oracle.translation(moved) - oracle.translation(measured) - [0.02, 0, 0]).max() < 1e-6


def test_after_the_latch_the_hands_are_one_rigid_body(rng):
    cooperation = core.Cooperation("mirror")
    hands, robot = motion(rng), robot_at_check_posture().astype(float)
    cooperation.start(hands[0], robot.astype(np.float32))
    cooperation.target(hands[10])
    cooperation.grasp()
    virtual = oracle.Algorithm1("teleop", hands[0], oracle.multiply(robot, oracle.pose(oracle.Q_X_PI, np.zeros(3))))
    relation = [
        oracle.multiply(oracle.conjugate(cooperation.target(hand).astype(float)), virtual.target(hand))
        for hand in hands[10:]
    ]
    assert max(oracle.pose_distance(r, relation[0]) for r in relation) < 3e-6


def test_latch_right_at_the_start_keeps_the_start_relation():
    cooperation, robot = core.Cooperation("mirror"), robot_at_check_posture()
    cooperation.start(hand_in_tracker(ONE, [0, 0, 0]), robot)
    cooperation.grasp()
    moved = cooperation.target(hand_in_tracker(ONE, [0.02, 0, 0]))
    assert np.abs(oracle.translation(moved) - oracle.translation(robot) - [0.02, 0, 0]).max() < 1e-6


# ---- changes during cooperation, as commanded on the bus


def c_pose(x: np.ndarray):
    pose = ffi.new("dual_quaternion_t *")
    ffi.memmove(pose, np.asarray(x, np.float32).tobytes(), 32)
    return lib.pose_from_dual_quaternion(pose[0])


def from_c(pose) -> np.ndarray:
    return np.frombuffer(ffi.buffer(ffi.new("dual_quaternion_t *", lib.pose_to_dual_quaternion(pose))), np.float32)


class Running:
    """A cooperation in progress, run with the firmware's functions."""

    def __init__(self, task: int, hand: np.ndarray, robot: np.ndarray):
        self.state, config = ffi.new("cooperation_t *"), ffi.new("cooperation_config_t *")
        parameters = ffi.new("parameters_t *")
        lib.parameters_set_defaults(parameters)
        lib.parameters_cooperation(parameters, config)
        lib.cooperation_start(self.state, config, ffi.addressof(lib.task_table, task), c_pose(hand), c_pose(robot))

    def target(self, hand: np.ndarray, blend: float = 1.0) -> np.ndarray:
        lib.cooperation_update(self.state, ffi.new("pose_t *", c_pose(hand)), blend)
        return from_c(self.state.target)


@pytest.mark.parametrize("task", [lib.TASK_POUR, lib.TASK_TELEOP, lib.TASK_MIRROR])
def test_a_blend_leads_from_the_robots_pose_to_the_task_without_a_step(rng, task):
    hand, robot = motion(rng, 1)[0], robot_at_check_posture()
    running = Running(task, hand, robot)
    way = np.array([running.target(hand, blend) for blend in np.linspace(0, 1, 101)])
    full = follow(["pour", "teleop", "mirror"][task], hand[None], robot)[0]
    assert oracle.pose_distance(way[0], robot) < 1e-6
    assert oracle.pose_distance(way[-1], full) < 1e-6
    steps = oracle.pose_distance(way[1:], way[:-1])
    assert steps.max() < 0.02 * max(oracle.pose_distance(full, robot), 1e-4)


@pytest.mark.parametrize("first", range(3))
@pytest.mark.parametrize("second", range(3))
def test_selecting_another_task_does_not_move_the_target(rng, first, second):
    hands, robot = motion(rng), robot_at_check_posture()
    running = Running(first, hands[0], robot)
    before = running.target(hands[20])
    lib.cooperation_select(running.state, ffi.addressof(lib.task_table, second))
    assert oracle.pose_distance(running.target(hands[20], 0.0), before) < 2e-6


@pytest.mark.parametrize("task", range(3))
def test_a_task_selected_during_cooperation_equals_one_selected_before(rng, task):
    """Selecting a task keeps the start poses of hand and robot. Therefore, after the blend, the result is the same as
    if the task had been selected before the start."""
    hands, robot = motion(rng), robot_at_check_posture()
    running = Running((task + 1) % 3, hands[0], robot)
    running.target(hands[20])
    lib.cooperation_select(running.state, ffi.addressof(lib.task_table, task))
    expected = follow(["pour", "teleop", "mirror"][task], hands, robot)
    assert oracle.pose_distance(np.array([running.target(hand) for hand in hands]), expected).max() < 5e-6


@pytest.mark.parametrize("task", range(3))
def test_a_clutch_takes_a_new_reference_at_the_robots_pose(rng, task):
    hands, robot = motion(rng), robot_at_check_posture()
    running = Running(task, hands[0], robot)
    running.target(hands[20])
    elsewhere = oracle.random_poses(rng, 1, 0.3)[0]
    lib.cooperation_clutch(running.state, c_pose(hands[-1]), c_pose(elsewhere), 1.0)
    assert oracle.pose_distance(running.target(hands[-1]), elsewhere) < 2e-6


def test_select_releases_a_latch(rng):
    hands, robot = motion(rng), robot_at_check_posture()
    running = Running(lib.TASK_MIRROR, hands[0], robot)
    running.target(hands[10])
    lib.cooperation_latch(running.state)
    assert running.state.latched
    lib.cooperation_select(running.state, ffi.addressof(lib.task_table, lib.TASK_TELEOP))
    assert not running.state.latched


def test_select_right_after_a_measured_latch_continues_from_the_robots_pose(rng):
    hands, robot = motion(rng), robot_at_check_posture()
    running = Running(lib.TASK_MIRROR, hands[0], robot)
    running.target(hands[10])
    elsewhere = oracle.random_poses(rng, 1, 0.3)[0]
    lib.cooperation_latch_measured(running.state, c_pose(elsewhere))
    lib.cooperation_select(running.state, ffi.addressof(lib.task_table, lib.TASK_TELEOP))
    assert oracle.pose_distance(running.target(hands[10], 0.0), elsewhere) < 2e-6


@pytest.mark.parametrize("task", ["teleop", "pour", "mirror"])
@pytest.mark.parametrize("motion_scale", [1.0, 0.3])
def test_the_targets_motion_is_its_derivative(rng, task, motion_scale):
    """The target's velocity agrees with a finite difference between two targets, which Algorithm 1 (tested above)
    computes for two slightly different hand poses."""
    apart_s = 0.01
    for _ in range(20):
        cooperation = core.Cooperation(task, scale=motion_scale)
        hand = oracle.random_poses(rng, 1, 0.3)[0].astype(float)
        cooperation.start(hand=hand.astype(np.float32), robot=oracle.random_poses(rng, 1, 0.3)[0])
        velocity, turning = rng.normal(0, 0.3, 3), rng.normal(0, 0.5, 3)

        def moved(t_s: float) -> np.ndarray:
            turn = oracle.rotation(turning, np.linalg.norm(turning) * t_s)
            place = oracle.translation(hand) + velocity * t_s
            return oracle.pose(oracle.quaternion_multiply(turn, hand[:4]), place).astype(np.float32)

        before, after = (cooperation.target(moved(t_s)).astype(float) for t_s in (-apart_s, apart_s))
        cooperation.target(moved(0.0))
        twist = ffi.new("twist_t *")
        twist.velocity_mps, twist.angular_velocity_radps = dict(zip("xyz", velocity)), dict(zip("xyz", turning))
        found = lib.cooperation_target_motion(cooperation._state, twist)
        turned = oracle.quaternion_multiply(after[:4], oracle.quaternion_conjugate(before[:4]))
        expected = (
            np.r_[(oracle.translation(after) - oracle.translation(before)) / 2, np.sign(turned[0]) * turned[1:]]
            / apart_s
        )
        motion = [getattr(part, axis) for part in (found.velocity_mps, found.angular_velocity_radps) for axis in "xyz"]
        assert motion == pytest.approx(expected, abs=1e-3)
