"""Runs the firmware in a closed loop without physics (_binding/kinematic_loop.h), given a hand motion and a tracker."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from comanip._core import ffi, lib

from comanip_dev.following.arm_model import ArmModel
from comanip_dev.following.recorded_hand import HandMotion
from comanip_dev.following.target import TASKS
from comanip_dev.following.tracker import Samples, Tracker

TICK_S = 1e-3
START_S = 0.5  # start of the cooperation
DRIVE_LAG_S = 3e-3
COOPERATING = lib.MODE_COOPERATING


class LoopError(Exception):
    """The run is not valid. The message is one line that states the reason."""


@dataclass(frozen=True)
class Run:
    """The arm's motion: joint angles in rad (T, n), commands in rad/s (T, n), and whether the arm cooperates (T,).
    There is one row per tick of 1 ms."""

    position_rad: np.ndarray
    command_radps: np.ndarray
    cooperating: np.ndarray


_NAMES = {
    ffi.string(lib.parameter_table[i].name).decode(): i for i in range(lib.PARAMETER_COUNT) if lib.parameters_has(i)
}


def knows(parameter: str) -> bool:
    """Returns True if this firmware has the parameter."""
    return parameter in _NAMES


def parameter_set(values: Mapping[str, float]):
    """Returns the firmware's parameters with these values, and with the defaults for all other parameters. Raises
    LoopError for an unknown name or a value out of range."""
    parameters = ffi.new("parameters_t *")
    lib.parameters_set_defaults(parameters)
    for name, value in values.items():
        if not knows(name):
            raise LoopError(f"parameter '{name}': expected one of {', '.join(_NAMES)}")
        if lib.parameters_set(parameters, _NAMES[name], value) != lib.RESULT_ACCEPTED:
            entry = lib.parameter_table[_NAMES[name]]
            raise LoopError(f"parameter {name}={value:g}: expected {entry.minimum:g} to {entry.maximum:g}")
    return parameters


def _frames(samples: Samples):
    frames = ffi.new("kinematic_sample_t[]", len(samples.valid))
    rows = zip(
        frames,
        samples.measured_us.tolist(),
        samples.received_us.tolist(),
        samples.position_m.tolist(),
        samples.rotation.tolist(),
        samples.valid.tolist(),
        strict=True,
    )
    for frame, measured_us, received_us, position_m, rotation, valid in rows:
        frame.received_us = received_us
        pose = frame.pose
        pose.t_us, pose.valid = measured_us, valid
        pose.position_m.x, pose.position_m.y, pose.position_m.z = position_m
        pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z = rotation
    return frames


def run_firmware(
    arm: ArmModel,
    task: str,
    start_rad: np.ndarray,
    motion: HandMotion,
    tracker: Tracker,
    samples: Samples,
    parameters: Mapping[str, float],
) -> Run:
    ticks = int(round(motion.duration_s / TICK_S))
    config = ffi.new("kinematic_loop_config_t *")
    config.ik = arm.arm.ik
    config.parameters = parameter_set(parameters)[0]
    config.lag_s = DRIVE_LAG_S
    config.period_us, config.latency_us = tracker.period_us, tracker.announced_latency_us
    config.task = TASKS[task]
    config.start_tick = int(round(START_S / TICK_S))
    out = ffi.new("kinematic_tick_t[]", ticks)
    start = ffi.new("double[]", list(map(float, start_rad)))
    if not lib.kinematic_loop_run(config, start, len(samples.valid), _frames(samples), ticks, out):
        raise LoopError("the firmware refused a frame, or refused to select or start the task")
    rows = np.frombuffer(ffi.buffer(out), _tick_type())
    count = arm.joint_count
    return Run(
        position_rad=rows["position_rad"][:, :count].copy(),
        command_radps=rows["command_radps"][:, :count].astype(float),
        cooperating=rows["mode"] == COOPERATING,
    )


def _tick_type() -> np.dtype:
    most = lib.ARM_MAX_JOINTS
    fields = dict(ffi.typeof("kinematic_tick_t").fields)
    formats = {"mode": "i4", "position_rad": (float, most), "command_radps": ("f4", most)}
    return np.dtype(
        {
            "names": list(formats),
            "formats": list(formats.values()),
            "offsets": [fields[name].offset for name in formats],
            "itemsize": ffi.sizeof("kinematic_tick_t"),
        }
    )
