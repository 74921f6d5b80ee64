"""Provides the firmware's implementation of Algorithm 1 of the paper."""

from __future__ import annotations

import numpy as np

from comanip._core import ffi, lib
from comanip.core import checks as check


def enumerators(kind: str, prefix: str) -> dict[str, int]:
    """Returns the values of a C enumeration by name, in lower case and without the prefix: {"pour": 0, ...}."""
    elements = sorted(ffi.typeof(kind).elements.items())
    return {name.removeprefix(prefix).lower(): number for number, name in elements}


_TASKS = {name: number for name, number in enumerators("task_id_t", "TASK_").items() if name != "custom"}
_LATCHES = ("commanded", "measured")


def choice(name: str, value: object, known) -> None:
    if not isinstance(value, str) or value not in known:
        raise ValueError(f"{name}: unknown name {value!r}: known are {', '.join(known)}")


def _pose(name: str, value: object):
    checked = check.poses(name, value, (8,))
    pose = ffi.new("dual_quaternion_t *")
    ffi.memmove(pose, checked.tobytes(), 32)
    return lib.pose_from_dual_quaternion(pose[0])


class Cooperation:
    """Maps the pose of the person's hand (tracker frame) to the target pose of the end effector (torso frame).

    task: "pour", "teleop" or "mirror" (Table I).
    tracker_rotation: rotation of the torso's axes in the tracker's frame, a unit quaternion (4,). The default is
        that of equation (9) in the paper.
    latch: whether grasp() latches the "commanded" or the "measured" q_task.
    scale: factor for the hand's displacement. The rotation is not scaled.
    start_offset: initial position of the person's hand minus that of the end effector, in m in torso axes (3,). The
        default is 0, as the paper assumes.
    """

    def __init__(
        self,
        task: str,
        tracker_rotation: np.ndarray | None = None,
        latch: str = "commanded",
        scale: float = 1.0,
        start_offset: np.ndarray | None = None,
    ) -> None:
        choice("task", task, _TASKS)
        choice("latch", latch, _LATCHES)
        self._task = ffi.addressof(lib.task_table, _TASKS[task])
        self._latch = latch
        self._started = False
        self._state = ffi.new("cooperation_t *")
        self._config = ffi.new("cooperation_config_t *")
        parameters = ffi.new("parameters_t *")
        lib.parameters_set_defaults(parameters)
        lib.parameters_cooperation(parameters, self._config)
        self._config.motion_scale = check.scalar("scale", scale, 0.0, above=True)
        if tracker_rotation is not None:
            rotation = check.unit_quaternion("tracker_rotation", tracker_rotation)
            ffi.memmove(ffi.addressof(self._config, "tracker_rotation"), rotation.tobytes(), 16)
        if start_offset is not None:
            offset = check.array("start_offset", start_offset, (3,))
            ffi.memmove(ffi.addressof(self._config, "start_offset_m"), offset.tobytes(), 12)

    def start(self, hand: np.ndarray, robot: np.ndarray) -> None:
        """Initialises Algorithm 1 with the poses of both hands. hand: (8,) in the tracker frame. robot: (8,) in the
        torso frame."""
        lib.cooperation_start(self._state, self._config, self._task, _pose("hand", hand), _pose("robot", robot))
        self._started = True

    def target(self, hand: np.ndarray) -> np.ndarray:
        """Returns the end effector's target (8,) for this pose (8,) of the person's hand."""
        self._require_start("target")
        lib.cooperation_update(self._state, ffi.new("pose_t *", _pose("hand", hand)), 1.0)
        vec8 = ffi.new("dual_quaternion_t *", lib.pose_to_dual_quaternion(self._state.target))
        return np.frombuffer(ffi.buffer(vec8), np.float32).copy()

    def grasp(self, robot: np.ndarray | None = None) -> None:
        """Latches q_task, so that it stays constant. With latch "commanded", q_task keeps its value from the latest
        call of target() or start(). With "measured", q_task becomes the present relative pose of the hands, computed
        from the end effector's measured pose `robot` (8,)."""
        self._require_start("grasp")
        measured = None if robot is None else _pose("robot", robot)
        if self._latch == "commanded":
            lib.cooperation_latch(self._state)
        elif measured is None:
            raise ValueError('robot: grasp() needs the robot\'s pose when latch is "measured"')
        else:
            lib.cooperation_latch_measured(self._state, measured)

    def _require_start(self, method: str) -> None:
        if not self._started:
            raise RuntimeError(f"Cooperation.{method}() before start(): call start() first")
