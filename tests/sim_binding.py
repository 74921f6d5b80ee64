"""Builds the simulator's bus, nodes and people with stand_in_scene.c in place of ODE: ``ffi, lib = load()``."""

from __future__ import annotations

import functools

import cffi
import simulator_library

MODULES = (
    "hal/common/frame_time", "sim/bus/bus", "sim/bus/candump_log", "sim/common/events", "sim/common/names",
    "sim/common/random", "sim/common/rigid_pose", "sim/hand/hand_history", "sim/hand/hand_path",
    "sim/hand/minimum_jerk", "sim/hand/playback", "sim/hand/recorded_motion", "sim/hand/recording", "sim/hand/tremor",
    "sim/nodes/operator_node", "sim/nodes/operator_script", "sim/nodes/tracker_node", "sim/people/approach",
    "sim/people/crank_turn", "sim/people/person_program", "sim/people/playlist", "sim/people/sight",
    "sim/scenario/forbidden_drop", "sim/scenario/step_wait",
)  # fmt: skip


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    return simulator_library.load(MODULES, stand_ins=["tests/stand_in_scene"])
