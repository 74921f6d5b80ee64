"""Builds the modules for convex shapes and proximity and the nodes of the gripper and of proximity, with libccd:
``ffi, lib = load()``. Tests set up their scene through fake_scene.h."""

from __future__ import annotations

import functools

import cffi
import simulator_library

MODULES = (
    "sim/bus/bus", "sim/nodes/gripper_node", "sim/nodes/proximity_node", "sim/proximity/bodies",
    "sim/proximity/convex_distance", "sim/proximity/convex_overlap", "sim/proximity/convex_shape",
    "sim/proximity/proximity", "sim/robot/robot_model",
)  # fmt: skip


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    return simulator_library.load(MODULES, stand_ins=["tests/fake_scene"], libraries=["ccd"])
