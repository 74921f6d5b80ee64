"""Checks that arm_check() names any value that is outside its range in arm.h, and accepts the end values of each
range."""

from __future__ import annotations

import numpy as np
import pytest
from comanip._core import ffi, lib

UNIT, ZERO = [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0]


def verdict(
    joint_count: int = 2,
    effector: tuple = (UNIT, ZERO),
    functions: bool = True,
    drive_lag_max_s: float = 0.013,
    **changes: object,
) -> str | None:
    """Returns arm_check()'s message about a table of two joints, or None. `changes` modifies the second joint; without
    changes the table is valid."""
    joints = ffi.new("arm_joint_t[2]")
    for joint in joints:
        joint.fixed = (UNIT, ZERO)
        joint.axis = [0.0, 0.0, 1.0]
        joint.position_min_rad, joint.position_max_rad, joint.velocity_max_radps = -1.0, 1.0, 2.0
        joint.jerk_max_radps3 = 1e4
    for name, value in changes.items():
        setattr(joints[1], name, value)
    table = ffi.new("arm_t *", {"joint_count": joint_count, "joints": joints, "effector": effector})
    table.drive_lag_max_s = drive_lag_max_s
    table.forward_kinematics = ffi.addressof(lib, "arm_forward_kinematics") if functions else ffi.NULL
    complaint = lib.arm_check(table)
    return None if complaint == ffi.NULL else ffi.string(complaint).decode()


HALF = np.sqrt(0.5)


@pytest.mark.parametrize(
    "changes",
    [{}, {"joint_count": 1}, {"fixed": (UNIT, [60.0, 0.0, 79.9])},
     {"effector": ([HALF, 0.0, -HALF, 0.0], [0.0, -99.9, 0.0])},
     {"axis": [0.0, -HALF, HALF]}, {"position_min_rad": -8.0, "position_max_rad": 8.0}, {"velocity_max_radps": 32.0},
     {"jerk_max_radps3": 1e3}, {"jerk_max_radps3": 1e6}, {"drive_lag_max_s": 1e-3}, {"drive_lag_max_s": 0.1}],
)  # fmt: skip
def test_a_table_within_its_ranges_is_accepted(changes):
    assert verdict(**changes) is None


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"joint_count": 0}, "joint_count"),
        ({"joint_count": 9}, "joint_count"),
        ({"functions": False}, "forward_kinematics"),
        ({"effector": ([0.9, 0.0, 0.0, 0.0], ZERO)}, "effector"),
        ({"effector": (UNIT, [0.0, 100.1, 0.0])}, "effector"),
        ({"effector": (UNIT, [0.0, float("nan"), 0.0])}, "effector"),
        ({"fixed": ([0.0, 0.0, 0.0, 0.0], ZERO)}, "fixed transform"),
        ({"fixed": (UNIT, [60.0, 0.0, 80.1])}, "fixed transform"),
        ({"axis": ZERO}, "axis"),
        ({"axis": [1.0, 1.0, 0.0]}, "axis"),
        ({"position_min_rad": 1.0}, "position limits"),
        ({"position_min_rad": -8.1}, "position limits"),
        ({"position_max_rad": 8.1}, "position limits"),
        ({"position_max_rad": float("nan")}, "position limits"),
        ({"velocity_max_radps": 0.0}, "velocity limit"),
        ({"velocity_max_radps": 32.1}, "velocity limit"),
        ({"velocity_max_radps": float("nan")}, "velocity limit"),
        ({"drive_lag_max_s": 0.9e-3}, "drive_lag_max_s"),
        ({"drive_lag_max_s": 0.11}, "drive_lag_max_s"),
        ({"drive_lag_max_s": float("nan")}, "drive_lag_max_s"),
        ({"jerk_max_radps3": 999.0}, "jerk limit"),
        ({"jerk_max_radps3": 1.01e6}, "jerk limit"),
        ({"jerk_max_radps3": float("nan")}, "jerk limit"),
    ],
)
def test_a_defect_is_named(changes, complaint):
    assert f"arm table: {complaint}" in verdict(**changes) or f"arm table: a joint's {complaint}" in verdict(**changes)


@pytest.mark.parametrize("missing", ["arm", "isotropic", "position_priority"])
def test_inverse_kinematics_without_a_member_are_refused(missing):
    """An arm_ik_t with a null member is refused, because calling a missing function would jump to address 0."""
    complete = ffi.new("arm_ik_t *", lib.arm_ik_any(ffi.addressof(lib.arm_hoap3_right)))
    assert lib.arm_ik_check(complete) == ffi.NULL
    setattr(complete, missing, ffi.NULL)
    assert b"isotropic and position_priority must be set" in ffi.string(lib.arm_ik_check(complete))
