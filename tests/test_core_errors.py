"""Checks that comanip.core refuses bad arguments with a message that names the argument and the reason."""

from __future__ import annotations

import numpy as np
import oracle
import pytest
from comanip import core

F = np.float32
HOAP3 = "hoap3_right"


def poses(count: int = 2) -> np.ndarray:
    return np.tile(np.array([1, 0, 0, 0, 0, 0, 0, 0], F), (count, 1))


def off_unit(error: float) -> np.ndarray:
    spoilt = poses()
    spoilt[1, 0] += error
    return spoilt


def not_orthogonal(error: float) -> np.ndarray:
    spoilt = poses()
    spoilt[1, 4] = error
    return spoilt


def with_nan(values: np.ndarray) -> np.ndarray:
    spoilt = values.copy()
    spoilt.flat[-1] = np.nan
    return spoilt


q = np.zeros((2, 4), F)
R, t = np.tile(np.eye(3, dtype=F), (2, 1, 1)), np.zeros((2, 3), F)

ARRAY_ARGUMENTS = [  # the function of this argument, the argument's name, a valid value
    (lambda x: core.multiply(x, poses()), "a", poses()),
    (lambda x: core.multiply(poses(), x), "b", poses()),
    (core.conjugate, "a", poses()),
    (core.normalise, "a", poses()),
    (lambda x: core.decompositional_multiply(x, poses()), "a", poses()),
    (lambda x: core.decompositional_multiply(poses(), x), "b", poses()),
    (lambda x: core.pose_from_matrix(x, t), "R", R),
    (lambda x: core.pose_from_matrix(R, x), "t", t),
    (lambda x: core.forward_kinematics(HOAP3, x), "q", q),
    (lambda x: core.pose_jacobian(HOAP3, x), "q", q),
    (lambda x: core.joint_velocity(HOAP3, x, poses(), 4.0, 1e-3), "q", q),
    (lambda x: core.joint_velocity(HOAP3, q, x, 4.0, 1e-3), "target", poses()),
    (lambda x: core.joint_velocity(HOAP3, q, poses(), x, 1e-3), "gain", np.ones(8, F)),
    (lambda x: core.joint_velocity(HOAP3, q, poses(), 4.0, 1e-3, weight=x), "weight", np.ones(8, F)),
    (lambda x: core.Cooperation("pour", tracker_rotation=x), "tracker_rotation", np.array([1, 0, 0, 0], F)),
    (lambda x: core.Cooperation("pour", start_offset=x), "start_offset", np.zeros(3, F)),
    (lambda x: core.Cooperation("pour").start(x, poses()[0]), "hand", poses()[0]),
    (lambda x: core.Cooperation("pour").start(poses()[0], x), "robot", poses()[0]),
    (lambda x: started("pour").target(x), "hand", poses()[0]),
    (lambda x: started("mirror", latch="measured").grasp(x), "robot", poses()[0]),
]


def started(task: str, **options) -> core.Cooperation:
    cooperation = core.Cooperation(task, **options)
    cooperation.start(poses()[0], poses()[0])
    return cooperation


def identify(case) -> str:
    return case[1]


@pytest.mark.parametrize("case", ARRAY_ARGUMENTS, ids=identify)
def test_array_arguments(case):
    call, name, good = case
    call(good)
    with pytest.raises(ValueError, match=rf"^{name}: .*float32.*float64"):
        call(good.astype(np.float64))
    with pytest.raises(ValueError, match=rf"^{name}: .*float32.*int64"):
        call(good.astype(np.int64))
    with pytest.raises(ValueError, match=rf"^{name}: .*list"):
        call(good.tolist())
    for wrong in (good[None], good[..., :-1], np.concatenate([good, good], axis=-1)):
        with pytest.raises(ValueError, match=rf"^{name}: .*shape"):
            call(wrong)
    with pytest.raises(ValueError, match=rf"^{name}: .*finite"):
        call(with_nan(good))


UNIT_ARGUMENTS = [case for case in ARRAY_ARGUMENTS if case[2].shape[-1] == 8 and case[1] not in ("gain", "weight")][4:]


@pytest.mark.parametrize("case", UNIT_ARGUMENTS, ids=identify)
def test_poses_off_unit(case):
    call, name, good = case
    for spoil in (off_unit, not_orthogonal):
        call(spoil(0.9e-4)[-len(good) :] if good.ndim == 2 else spoil(0.9e-4)[1])
        with pytest.raises(ValueError, match=rf"^{name}: not a unit dual quaternion.*0\.0001"):
            call(spoil(1.1e-4) if good.ndim == 2 else spoil(1.1e-4)[1])


@pytest.mark.parametrize("function", [core.multiply, core.decompositional_multiply])
def test_different_lengths(function):
    with pytest.raises(ValueError, match="^b: expected 2 rows, as many as a, got 3"):
        function(poses(2), poses(3))


def test_different_lengths_of_matrices_and_joints():
    with pytest.raises(ValueError, match="^t: expected 2 rows"):
        core.pose_from_matrix(R, np.zeros((3, 3), F))
    with pytest.raises(ValueError, match="^target: expected 2 rows"):
        core.joint_velocity(HOAP3, q, poses(3), 4.0, 1e-3)


def test_a_pose_has_a_row_number_in_the_message():
    with pytest.raises(ValueError, match="^a: .* in row 1"):
        core.decompositional_multiply(off_unit(0.01), poses())


def test_normalise_needs_a_primary_part():
    with pytest.raises(ValueError, match="^a: row 1 has a primary part of norm 0"):
        core.normalise(np.array([[1, 0, 0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 1, 0, 0, 0]], F))


@pytest.mark.parametrize("matrix", [1.001 * np.eye(3), np.diag([1, 1, -1]), np.zeros((3, 3))])
def test_matrices_that_are_not_rotations(matrix):
    with pytest.raises(ValueError, match="^R: .*(rotation|reflection)"):
        core.pose_from_matrix(matrix[None].astype(F), t[:1])


@pytest.mark.parametrize("angle", [64.1, -100.0])
def test_angles_out_of_range(angle):
    with pytest.raises(ValueError, match=rf"^q: .*64 rad, got {angle:g}"):
        core.forward_kinematics(HOAP3, np.array([[0, 0, angle, 0]], F))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: core.forward_kinematics("hoap4", q), "^arm: unknown name 'hoap4': known are .*hoap3_right"),
        (lambda: core.pose_jacobian(None, q), "^arm: expected a name or an Arm, got NoneType"),
        (lambda: core.joint_velocity(HOAP3, q, poses(), 4.0, 1e-3, "hand"), "^error_frame: unknown name 'hand'.*torso"),
        (lambda: core.Cooperation("dance"), "^task: unknown name 'dance': known are pour, teleop, mirror"),
        (lambda: core.Cooperation("custom"), "^task: unknown name 'custom'"),
        (lambda: core.Cooperation("pour", latch="held"), "^latch: unknown name 'held': known are commanded, measured"),
        (lambda: core.Cooperation(["pour"]), "^task: unknown name"),
    ],
)
def test_unknown_names(call, message):
    with pytest.raises(ValueError, match=message):
        call()


@pytest.mark.parametrize("bad", [-1.0, np.nan, np.inf, "4", None, True])
@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("gain", lambda x: core.joint_velocity(HOAP3, q, poses(), x, 1e-3)),
        ("damping", lambda x: core.joint_velocity(HOAP3, q, poses(), 4.0, x)),
        ("weight", lambda x: core.joint_velocity(HOAP3, q, poses(), 4.0, 1e-3, weight="1" if x is None else x)),
        ("scale", lambda x: core.Cooperation("pour", scale=x)),
    ],
)
def test_numbers(name, call, bad):
    with pytest.raises(ValueError, match=f"^{name}: expected a"):
        call(bad)


@pytest.mark.parametrize("number", [1e39, 1e-50])
def test_numbers_beyond_float32(number):
    with pytest.raises(ValueError, match="^scale: .*float32"):
        core.Cooperation("pour", scale=number)


def test_negative_components():
    negative = np.array([1, 1, 1, -2, 1, 1, 1, 1], F)
    with pytest.raises(ValueError, match="^gain: component 3 is negative: -2"):
        core.joint_velocity(HOAP3, q, poses(), negative, 1e-3)
    with pytest.raises(ValueError, match="^scale: .*above 0 .*got 0"):
        core.Cooperation("pour", scale=0)


def test_cooperation_has_to_be_started():
    for call in (lambda c: c.target(poses()[0]), lambda c: c.grasp()):
        with pytest.raises(RuntimeError, match=r"before start\(\)"):
            call(core.Cooperation("mirror"))


def test_latch_measured_needs_the_robots_pose():
    with pytest.raises(ValueError, match="^robot: .*measured"):
        started("mirror", latch="measured").grasp()


def arm(**changes) -> core.Arm:
    good = {
        "fixed": poses(2),
        "axis": np.array([[0, 0, 1], [0, 1, 0]], F),
        "position_min_rad": np.array([-1, -1], F),
        "position_max_rad": np.array([1, 1], F),
        "velocity_max_radps": np.array([2, 2], F),
        "effector": poses(1)[0],
    }
    return core.Arm(**(good | changes))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"fixed": poses(9)}, "^fixed: an arm has 1 to 8 joints, got 9"),
        ({"fixed": poses(0)}, "^fixed: an arm has 1 to 8 joints, got 0"),
        ({"fixed": off_unit(0.1)}, "^fixed: not a unit dual quaternion"),
        ({"axis": np.ones((2, 3), F)}, "axis is not a unit vector"),
        ({"axis": np.ones((3, 3), F)}, "^axis: .*shape"),
        ({"position_min_rad": np.array([2, -1], F)}, "position limits must be ordered"),
        ({"position_max_rad": np.array([9, 1], F)}, "within .*8 rad"),
        ({"velocity_max_radps": np.array([0, 2], F)}, "velocity limit must be above 0"),
        ({"velocity_max_radps": np.array([33, 2], F)}, "at most 32"),
        ({"jerk_max_radps3": np.array([2e4, 500], F)}, "jerk limit must be from 1000 to 1e6"),
        ({"drive_lag_max_s": 0.0}, "drive_lag_max_s must be from 0.001 to 0.1 s"),
        ({"drive_lag_max_s": 0.2}, "drive_lag_max_s must be from 0.001 to 0.1 s"),
        ({"drive_lag_max_s": float("nan")}, "drive_lag_max_s must be from 0.001 to 0.1 s"),
        ({"jerk_max_radps3": np.array([2e4], F)}, "^jerk_max_radps3: .*shape"),
        ({"effector": off_unit(0.1)[1]}, "^effector: not a unit dual quaternion"),
    ],
)
def test_user_defined_arms_are_checked(changes, message):
    arm()
    with pytest.raises(ValueError, match=message):
        arm(**changes)


def test_arms_lists_the_available_names():
    assert HOAP3 in core.arms()
    for name in core.arms():
        core.forward_kinematics(name, np.zeros((1, core.Arm.named(name).joint_count), F))


def test_an_arm_lives_as_long_as_it_is_used(rng):
    """An arm still works after the tables of other arms have been created and freed."""
    kept = arm()
    angles = rng.uniform(-1, 1, (50, 2)).astype(F)
    before = core.forward_kinematics(kept, angles)
    for _ in range(200):
        arm(fixed=oracle.random_poses(rng, 2))
    assert np.array_equal(core.forward_kinematics(kept, angles), before)


def test_empty_arrays_and_views_are_fine(rng):
    assert core.multiply(poses(0), poses(0)).shape == (0, 8)
    assert core.forward_kinematics(HOAP3, q[:0]).shape == (0, 4 + 4)
    assert core.pose_jacobian(HOAP3, q[:0]).shape == (0, 8, 4)
    wide = np.asfortranarray(oracle.random_poses(rng, 20))
    assert np.array_equal(core.conjugate(wide[::2]), core.conjugate(np.ascontiguousarray(wide[::2])))


def test_inputs_are_not_written():
    a = oracle.random_poses(np.random.default_rng(1), 5)
    before = a.copy()
    core.normalise(a), core.multiply(a, a), core.decompositional_multiply(a, a)
    assert np.array_equal(a, before)
