"""The simulator's parts without ODE, and stand_in_scene.c in its place, as a Python library: ``ffi, lib = load()``."""

from __future__ import annotations

import functools

import c_library
import cffi
from c_declarations import declarations
from c_library import CORE, REPOSITORY

PARTS = [
    REPOSITORY / "sim" / name
    for name in (
        "bus/bus", "bus/candump_log", "bus/frame_time", "common/events", "common/names", "common/random",
        "common/rigid_pose", "people/approach", "people/crank_turn", "hand/hand_history", "hand/hand_path",
        "hand/minimum_jerk", "hand/playback", "people/playlist", "hand/recorded_motion", "hand/recording", "people/sight",
        "scenario/forbidden_drop", "scenario/step_wait", "hand/tremor", "nodes/operator_node", "nodes/operator_script", "nodes/tracker_node",
        "people/person_program",
    )
] + [REPOSITORY / "tests" / "stand_in_scene"]  # fmt: skip
ENDPOINT = REPOSITORY / "sim" / "bus" / "endpoint.c"
SOURCES = [part.with_suffix(".c") for part in PARTS] + [ENDPOINT] + CORE
HEADERS = [part.with_suffix(".h") for part in PARTS]


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    return c_library.load("sim", declarations(HEADERS), SOURCES)
