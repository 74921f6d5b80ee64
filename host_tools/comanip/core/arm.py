"""Provides the arms: those that are built into the firmware have names, others are defined by arrays."""

from __future__ import annotations

import numpy as np

from comanip._core import ffi, lib
from comanip.core import checks as check

# the same defaults as in arm descriptions, firmware/arms/*.toml
JERK_DEFAULT_RADPS3 = 1e4
DRIVE_LAG_MAX_DEFAULT_S = 0.013
_IDENTITY = np.array([1, 0, 0, 0, 0, 0, 0, 0], np.float32)


def _built_in() -> dict[str, object]:
    """Returns the arm_ik_t of each arm that is linked into the firmware, by the arm's name."""
    symbols = (getattr(lib, name) for name in dir(lib) if name.startswith("arm_ik_"))
    found = [
        symbol for symbol in symbols if isinstance(symbol, ffi.CData) and ffi.typeof(symbol) is ffi.typeof("arm_ik_t")
    ]
    return {ffi.string(ik.arm.name).decode(): ik for ik in found}


_BUILT_IN = _built_in()


def _pose(x: np.ndarray):
    """Converts a dual quaternion (8,) to pose_t."""
    return lib.pose_from_dual_quaternion(ffi.from_buffer("dual_quaternion_t *", x)[0])


def arms() -> list[str]:
    """Returns the names of the firmware's built-in arms."""
    return sorted(_BUILT_IN)


class Arm:
    """A serial arm of n = 1..8 revolute joints. Functions with a parameter `arm` accept an Arm or the name of a
    built-in arm.

    fixed[i] is the pose of joint i relative to the moving frame of the previous joint (for the first joint: the torso).
    Joint i turns about axis[i]. `effector` is the pose of the end effector relative to the last joint's moving frame.
    All arrays are float32: fixed (n, 8) with unit dual quaternions, axis (n, 3) with unit vectors, limits (n,). The
    default jerk limit is 10,000 rad/s^3. drive_lag_max_s (0.001 to 0.1) is the largest time by which a healthy drive's
    reported motion lags behind its command.
    """

    def __init__(
        self,
        fixed: np.ndarray,
        axis: np.ndarray,
        position_min_rad: np.ndarray,
        position_max_rad: np.ndarray,
        velocity_max_radps: np.ndarray,
        effector: np.ndarray | None = None,
        name: str = "custom",
        jerk_max_radps3: np.ndarray | None = None,
        drive_lag_max_s: float = DRIVE_LAG_MAX_DEFAULT_S,
    ) -> None:
        fixed = check.poses("fixed", fixed, ("n", 8))
        count = len(fixed)
        most = lib.ARM_MAX_JOINTS
        if not 1 <= count <= most:
            raise ValueError(f"fixed: an arm has 1 to {most} joints, got {count} rows")
        axis = check.array("axis", axis, (count, 3))
        if jerk_max_radps3 is None:
            jerk_max_radps3 = np.full(count, JERK_DEFAULT_RADPS3, np.float32)
        limits = [
            check.array(limit_name, value, (count,))
            for limit_name, value in (
                ("position_min_rad", position_min_rad),
                ("position_max_rad", position_max_rad),
                ("velocity_max_radps", velocity_max_radps),
                ("jerk_max_radps3", jerk_max_radps3),
            )
        ]
        effector = check.poses("effector", _IDENTITY if effector is None else effector, (8,))

        joints = ffi.new("arm_joint_t[]", count)
        for row, joint in enumerate(joints):
            joint.fixed = _pose(fixed[row])
            ffi.memmove(ffi.addressof(joint, "axis"), axis[row].tobytes(), 12)
            joint.position_min_rad, joint.position_max_rad, joint.velocity_max_radps, joint.jerk_max_radps3 = (
                v[row] for v in limits
            )
        table = ffi.new("arm_t *")
        self._keep_alive = (joints, ffi.new("char[]", name.encode()), table)
        table.name = self._keep_alive[1]
        table.joint_count = count
        table.drive_lag_max_s = drive_lag_max_s
        table.joints = joints
        table.effector = _pose(effector)
        table.forward_kinematics = ffi.addressof(lib, "arm_forward_kinematics")
        defect = lib.arm_check(table)
        if defect != ffi.NULL:
            raise ValueError(ffi.string(defect).decode())
        self._take(ffi.new("arm_ik_t *", lib.arm_ik_any(table)))

    @classmethod
    def named(cls, name: str) -> Arm:
        """Returns a built-in arm. Raises ValueError if the name is not in arms()."""
        if name not in _BUILT_IN:
            raise ValueError(f"arm: unknown name {name!r}: known are {', '.join(arms())}")
        self = cls.__new__(cls)
        self._take(ffi.addressof(_BUILT_IN[name]))
        return self

    def _take(self, ik) -> None:
        """Sets the attributes from ik, an arm_ik_t *."""
        self.ik, self.table = ik, ik.arm
        table = self.table
        self.name: str = ffi.string(table.name).decode()
        self.joint_count: int = table.joint_count
        self.drive_lag_max_s: float = table.drive_lag_max_s
        joints = [table.joints[i] for i in range(table.joint_count)]
        self.position_min_rad = np.array([joint.position_min_rad for joint in joints], np.float32)
        self.position_max_rad = np.array([joint.position_max_rad for joint in joints], np.float32)
        self.velocity_max_radps = np.array([joint.velocity_max_radps for joint in joints], np.float32)
        self.jerk_max_radps3 = np.array([joint.jerk_max_radps3 for joint in joints], np.float32)


def resolve(arm: str | Arm) -> Arm:
    if isinstance(arm, Arm):
        return arm
    if not isinstance(arm, str):
        raise ValueError(f"arm: expected a name or an Arm, got {type(arm).__name__}")
    return Arm.named(arm)
