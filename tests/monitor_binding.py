"""Builds the monitors with monitor_scene.c in place of ODE: ``ffi, lib = load()``."""

from __future__ import annotations

import functools

import cffi
import simulator_library

MODULES = (
    "firmware/parameters/parameters", "sim/common/events", "sim/hand/tremor", "sim/monitors/bus_delays",
    "sim/monitors/check_window", "sim/monitors/contact_monitor", "sim/monitors/delay_fit", "sim/monitors/latency",
    "sim/monitors/measure", "sim/monitors/measurement", "sim/monitors/physical_state", "sim/monitors/reach",
    "sim/monitors/rest_monitor", "sim/monitors/rest_noise", "sim/monitors/scenario_monitor", "sim/monitors/tracking",
    "sim/output/trace_csv", "sim/robot/position_jacobian", "sim/robot/robot_model",
)  # fmt: skip


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    return simulator_library.load(MODULES, stand_ins=["tests/monitor_scene"])
