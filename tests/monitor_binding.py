"""The monitors as a Python library, ``ffi, lib = load()``: with monitor_scene.c in the place of ODE."""

from __future__ import annotations

import functools

import c_library
import cffi
from c_declarations import declarations
from c_library import CORE, GENERATED, REPOSITORY

PARTS = (
    "common/events", "common/names", "common/random", "common/rigid_pose", "common/solve_3x3", "hand/minimum_jerk", "hand/tremor",
    "monitors/bus_delays", "monitors/check_window", "monitors/contact_monitor", "monitors/delay_fit",
    "monitors/latency", "monitors/measure", "monitors/measurement",
    "monitors/physical_state", "monitors/reach", "monitors/rest_monitor", "monitors/rest_noise",
    "monitors/scenario_monitor", "monitors/tracking", "output/text_number", "output/trace_csv",
    "robot/position_jacobian", "robot/robot_model",
)  # fmt: skip

SCENE = REPOSITORY / "tests" / "monitor_scene.c"


@functools.cache
def load() -> tuple[cffi.FFI, object]:

    declared = declarations((REPOSITORY / "sim" / f"{part}.h" for part in PARTS), f"-I{GENERATED}")
    sources = [REPOSITORY / "sim" / f"{part}.c" for part in PARTS] + [SCENE] + CORE
    return c_library.load("monitors", declared, sources)
