"""Builds a physical scene for a test, without a bus or files: an arm that holds still, people, rods, stands and
cranks."""

from __future__ import annotations

import numpy as np
import plant_binding
from scipy.spatial.transform import Rotation

ffi, lib = plant_binding.load()

GRAVITY_MPS2 = 9.80665
ALONG_Z, ALONG_X, ALONG_Y = (1, 0, 0, 0), (0.5**0.5, 0, 0.5**0.5, 0), (0.5**0.5, -(0.5**0.5), 0, 0)  # object axes
START_DEG = (90, -5, 0, -90)


class Scene:
    """A physical scene. People and objects are dicts with the field names of scenario.h as keys. Lists and strings are
    converted to C."""

    def __init__(self, people=(), objects=(), start_deg=START_DEG, gripper=None, step_s=1e-3):
        self.step_s, self.now_s = step_s, 0.0
        self.scenario = ffi.new("scenario_t *")
        self.scenario.start_deg = start_deg
        self.scenario.person_count, self.scenario.object_count = len(people), len(objects)
        for i, person in enumerate(people):
            fill(self.scenario.person[i], {**PERSON, "name": f"person{i}", **person})
        for i, thing in enumerate(objects):
            fill(self.scenario.object[i], {**OBJECT[thing["kind"]], "name": f"object{i}", **thing})
        fill(self.scenario.gripper, {**GRIPPER, **(gripper or {})})
        self.events = ffi.addressof(self.scenario, "events")
        lib.events_init(self.events)
        self._declare("robot", "holds", "lost", "opened", "closed")
        for i in range(len(people)):
            self._declare(f"person{i}", "holds", "lost")
        for i in range(len(objects)):
            self._declare(f"object{i}", "dropped")
        self.scene = lib.scene_create(self.scenario, self.events)
        assert self.scene != ffi.NULL
        self.arm = lib.scene_arm(self.scene)

    def _declare(self, actor: str, *events: str) -> None:
        for what in events:
            assert lib.events_declare(self.events, actor.encode(), what.encode()) >= 0

    def __enter__(self) -> Scene:
        return self

    def __exit__(self, *_) -> None:
        lib.scene_destroy(self.scene)

    def set_gravity(self, z_mps2: float) -> None:
        lib.dWorldSetGravity(lib.dBodyGetWorld(lib.arm_plant_hand_body(self.arm)), 0, 0, z_mps2)

    def step(self, steps: int = 1) -> None:
        for _ in range(steps):
            lib.scene_step(self.scene, self.now_s, self.step_s)
            self.now_s += self.step_s

    def aim(self, person: int, position_m, rotation=(1, 0, 0, 0)) -> None:
        lib.scene_aim_hand(self.scene, person, ffi.new("rigid_pose_t *", (list(position_m), list(rotation)))[0:1])

    def pose(self, call, *arguments) -> tuple[np.ndarray, Rotation]:
        """Calls a function such as scene_hand() and returns the position (3,) in m and the rotation that it reports."""
        pose = ffi.new("rigid_pose_t *")
        call(self.scene, *arguments, pose)
        w, x, y, z = pose.rotation
        return np.array(list(pose.position_m)), Rotation.from_quat([x, y, z, w])

    def hand(self, person: int = 0) -> tuple[np.ndarray, Rotation]:
        return self.pose(lib.scene_hand, person)

    def thing(self, index: int = 0) -> tuple[np.ndarray, Rotation]:
        return self.pose(lib.scene_object, index)

    def point(self, kind: str, index: int = 0, point: int = 0) -> np.ndarray:
        position = ffi.new("double[3]")
        lib.scene_point(self.scene, ffi.new("point_t *", (getattr(lib, kind), index, point)), position)
        return np.array(list(position))

    def hand_force(self, person: int = 0) -> np.ndarray:
        force = ffi.new("double[3]")
        lib.scene_hand_force_N(self.scene, person, force)
        return np.array(list(force))

    def grip(self, person: int = 0, thing: int = 0) -> bool:
        return lib.scene_close_hand(self.scene, person, thing)

    def times(self, event: str) -> int:
        """Returns how many times the event has occurred."""
        return self.events.event[lib.events_find(self.events, event.encode())].times

    def first_s(self, event: str) -> float:
        return self.events.event[lib.events_find(self.events, event.encode())].first_s


PERSON = {
    "start": ([0.4, 0.2, 0.0], [1, 0, 0, 0]), "mass_kg": 1.5, "stiffness_Npm": 300.0, "damping_ratio": 0.4,
    "stiffness_Nmprad": 3.0, "grip_force_limit_N": 60.0,
}  # fmt: skip
ROD = {
    "kind": lib.OBJECT_ROD, "pose": ([0.4, 0.2, 0.0], ALONG_Y), "length_m": 0.3, "radius_m": 0.008, "mass_kg": 0.08,
    "robot_grip": lib.GRIP_BALL, "person_grip": lib.GRIP_BALL,
}  # fmt: skip
CRANK = {
    "kind": lib.OBJECT_CRANK, "pose": ([0.5, 0.2, 0.0], ALONG_Y), "length_m": 0.2, "radius_m": 0.05, "mass_kg": 0.1,
    "robot_grip": lib.GRIP_BALL, "person_grip": lib.GRIP_BALL,
}  # fmt: skip
STAND = {"kind": lib.OBJECT_STAND, "size_m": [0.06, 0.12, 0.04]}
OBJECT = {lib.OBJECT_ROD: ROD, lib.OBJECT_CRANK: CRANK, lib.OBJECT_STAND: STAND}
GRIPPER = {
    "offset_m": [0, 0, 0.03], "stroke_s": 0.3, "capture_m": 0.015, "stiffness_Npm": 3000.0, "damping_Nspm": 30.0,
    "force_limit_N": 25.0, "torque_limit_Nm": 1.0,
}  # fmt: skip


def fill(target, values: dict) -> None:
    for name, value in values.items():
        setattr(target, name, value.encode() if isinstance(value, str) else value)
