"""Convex shapes, proximity and the nodes of gripper and proximity sensor as a Python library, over a scene that tests
set up (fake_scene.h): ``ffi, lib = load()``. Needs libccd and build/generated."""

from __future__ import annotations

import functools
import subprocess
import tempfile
from pathlib import Path

import cffi
from c_declarations import declarations
from sim_binding import BUILD, COMPILE, FIRMWARE, REPOSITORY

PARTS = (
    "bus/bus", "bus/frame_time", "common/rigid_pose", "nodes/gripper_node", "nodes/proximity_node", "proximity/bodies",
    "proximity/convex_shape", "proximity/proximity", "robot/robot_model",
)  # fmt: skip
WITHOUT_HEADER = ("bus/endpoint", "proximity/body_shapes", "proximity/convex_overlap", "proximity/convex_support")
PROTOCOL = (
    "can_classic",
    "can_protocol",
    "can_transport",
    "comanip_dbc",
    "dual_quaternion",
    "pose",
    "e2e",
    "rotation_code",
    "trigonometry",
)
FAKE_SCENE = REPOSITORY / "tests" / "fake_scene.h"


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    """Compiled anew in each test run: a few seconds, and never stale. Optimised: the tests search many distances."""
    BUILD.mkdir(parents=True, exist_ok=True)
    sources = [str(REPOSITORY / "sim" / f"{part}.c") for part in (*PARTS, *WITHOUT_HEADER)]
    sources += [str(file) for file in FIRMWARE if file.stem in PROTOCOL]
    ffi = cffi.FFI()
    with tempfile.TemporaryDirectory(dir=BUILD) as name:
        folder = Path(name)
        ffi.cdef(declarations((FAKE_SCENE, *(REPOSITORY / "sim" / f"{part}.h" for part in PARTS))))
        library = folder / "proximity.so"
        sources.append(str(FAKE_SCENE.with_suffix(".c")))
        command = [*COMPILE, "-O2", "-ffp-contract=off", "-shared", *sources, "-lccd", "-lm", "-o", str(library)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}\n{done.stderr}")
        return ffi, ffi.dlopen(str(library))
