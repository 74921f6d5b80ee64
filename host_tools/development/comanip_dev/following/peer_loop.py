"""Runs other programs (peers) as followers in the same closed loop as the firmware, with the same tracker frames,
limiter, bus times, drives and encoders. A peer replaces only the computation of joint velocities from the hand's
samples.

In each tick, a follower receives the measured joint positions and the target for the newest sample. The target is
computed by Algorithm 1, from the sample at the start of the cooperation, as in the firmware.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from comanip._core import ffi, lib
from comanip.core import checks as check

from comanip_dev.following import rotations
from comanip_dev.following.arm_model import ArmModel
from comanip_dev.following.loop import DRIVE_LAG_S, START_S, TICK_S, Run, parameter_set
from comanip_dev.following.recorded_hand import HandMotion
from comanip_dev.following.target import targets
from comanip_dev.following.tracker import MOUNT_ROTATION, Samples, Tracker

PULSES_PER_RAD = 209.0 * 180.0 / np.pi


class Velocities(Protocol):
    """A function that returns (feedback_radps, feedforward_radps), both (n,). Feedback corrects the error, feedforward
    follows the target's motion. target: index of the newest sample."""

    def __call__(self, target: int, measured_rad: np.ndarray) -> tuple[np.ndarray, np.ndarray]: ...


# A function that creates Velocities from (arm, start posture, times of the samples in s (N,), their target positions
# (N, 3) and target rotations (N, 4)).
MakeVelocities = Callable[[ArmModel, np.ndarray, np.ndarray, np.ndarray, np.ndarray], Velocities]


def sample_targets(
    arm: ArmModel, task: str, start_rad: np.ndarray, samples: Samples, reference: int
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the end effector's target for each sample. reference: index of the sample at the start of the
    cooperation."""
    displacement_m = rotations.rotate(MOUNT_ROTATION, samples.position_m - samples.position_m[reference])
    in_torso = rotations.multiply(MOUNT_ROTATION, samples.rotation)
    turn = rotations.multiply(in_torso, rotations.conjugate(in_torso[reference]))
    start_m, start_rotation = arm.hand(start_rad[None])
    return targets(task, start_m[0], start_rotation[0], displacement_m, turn)


def run_peer(
    make: MakeVelocities,
    gain_per_s: float,
    arm: ArmModel,
    task: str,
    start_rad: np.ndarray,
    motion: HandMotion,
    tracker: Tracker,
    samples: Samples,
) -> Run:
    """Runs a follower once. gain_per_s: gain of the follower, which the limiter's approach rule uses."""
    ticks, count = int(round(motion.duration_s / TICK_S)), arm.joint_count
    start = int(round(START_S / TICK_S))
    seen = np.flatnonzero(samples.valid)
    newest = seen[np.maximum(np.searchsorted(samples.received_us[seen], np.arange(ticks) * 1000, side="right") - 1, 0)]
    target_m, target_rotation = sample_targets(arm, task, start_rad, samples, newest[start])
    velocities = make(arm, start_rad, samples.measured_us * 1e-6, target_m, target_rotation)

    config = ffi.new("joint_limits_config_t *")
    lib.parameters_joint_limits(parameter_set({}), arm.arm.table, TICK_S, config)
    config.approach_gain_per_s = gain_per_s
    lib.joint_limits_prepare(config, arm.arm.table)
    limits = ffi.new("joint_limits_t *")
    lib.joint_limits_init(limits)
    state = ffi.new("kinematic_arm_t *")
    lib.kinematic_arm_init(state, count, DRIVE_LAG_S, ffi.new("double[]", start_rad.tolist()))
    measured, error, feedforward = np.zeros((3, count), np.float32)
    measured[:] = np.rint(start_rad * PULSES_PER_RAD) / PULSES_PER_RAD
    now_rad = np.frombuffer(ffi.buffer(state.position_rad), float)[:count]
    command = np.frombuffer(ffi.buffer(limits.velocity_radps), np.float32)[:count]
    pointers = [check.pointer("float", values) for values in (measured, error, feedforward)]
    limited = ffi.addressof(limits, "velocity_radps")

    position_rad, command_radps = np.zeros((ticks, count)), np.zeros((ticks, count))
    for k in range(ticks):
        if k > start:
            error[:], feedforward[:] = velocities(newest[k], measured.astype(float))
        lib.joint_limits_apply(limits, arm.arm.table, config, *pointers)
        position_rad[k], command_radps[k] = now_rad, command
        lib.kinematic_arm_step(state, ffi.cast("float *", limited), pointers[0])
    return Run(position_rad, command_radps, np.arange(ticks) >= start)
