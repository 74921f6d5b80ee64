"""Convex shapes, proximity and the nodes of gripper and proximity sensor as a Python library, over a scene that tests
set up (fake_scene.h): ``ffi, lib = load()``. Needs libccd."""

from __future__ import annotations

import functools

import c_library
import cffi
from c_declarations import declarations
from c_library import CORE, OPTIMISED, REPOSITORY

PARTS = (
    "bus/bus", "bus/frame_time", "common/rigid_pose", "nodes/gripper_node", "nodes/proximity_node", "proximity/bodies",
    "proximity/convex_shape", "proximity/proximity", "robot/robot_model",
)  # fmt: skip
WITHOUT_HEADER = ("bus/endpoint", "proximity/body_shapes", "proximity/convex_overlap", "proximity/convex_support")
FAKE_SCENE = REPOSITORY / "tests" / "fake_scene.h"


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    """Optimised: the tests search many distances."""
    headers = [FAKE_SCENE, *(REPOSITORY / "sim" / f"{part}.h" for part in PARTS)]
    sources = [REPOSITORY / "sim" / f"{part}.c" for part in (*PARTS, *WITHOUT_HEADER)]
    sources += [FAKE_SCENE.with_suffix(".c"), *CORE]
    return c_library.load("proximity", declarations(headers), sources, *OPTIMISED, libraries=["ccd"])
