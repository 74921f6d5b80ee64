"""Checks that the monitor of JointCmd frames finds each kind of violation and reports none for valid frames, and that
the names that the simulator prints match the DBC's."""

from __future__ import annotations

import numpy as np
import plant_binding
import pytest

ffi, lib = plant_binding.load()
TICK_NS = 1_000_000
ACCELERATION = 25.0


class Watch:
    def __init__(self, speed_fraction=1.0):
        self.speed_fraction = speed_fraction
        self.monitor = ffi.new("limit_monitor_t *")
        lib.limit_monitor_init(self.monitor)
        self.now_ns = 0

    def command(self, velocity=(0, 0, 0, 0), position=(1.0, -0.5, 0.0, -1.0), mode=(1, 1, 1, 1), ticks=1, extra=None):
        self.now_ns += ticks * TICK_NS
        message = ffi.new("joint_cmd_t *")
        for i in range(4):
            message.mode[i], message.position_rad[i], message.velocity_radps[i] = mode[i], position[i], velocity[i]
        if extra is not None:
            message.velocity_radps[6] = extra
        lib.limit_monitor_command(self.monitor, message, self.now_ns, self.speed_fraction, ACCELERATION)
        return self.monitor.violations


def ramp(target, jerk=10_000.0):
    """Returns velocities, one per tick, that rise from 0 to just below the target with acceleration and jerk at their
    limits."""
    rise = np.arange(0.0, ACCELERATION, jerk * 1e-3)
    level = round(target / (ACCELERATION * 1e-3)) - len(rise)
    return np.cumsum(np.r_[rise, np.full(level, ACCELERATION), rise[::-1]]) * 1e-3


def test_a_ramp_at_the_limits_is_not_a_violation():
    watch = Watch()
    for velocity in ramp(4.7):
        assert watch.command([velocity] * 4) == 0
    # one frame was lost, so twice the time has passed and twice the change is allowed
    assert watch.command([velocity - 0.015] * 4, ticks=2) == 0
    assert watch.command([velocity - 0.015 - 0.02] * 4) == 0


def test_each_frame_of_a_fourfold_tick():
    """With frames every 4 ms, as on classic CAN, one tick suffices for the acceleration to rise from zero to its limit,
    and one more for it to fall back."""
    watch = Watch()
    for velocity in (0, 0, 0.1, 0.2, 0.3, 0.3, 0.3, 0.24, 0.14):
        assert watch.command([velocity] * 4, ticks=4) == 0
    assert watch.command([0.201] * 4, ticks=4) == 4  # the acceleration changes from -25 to 15.25 rad/s^2 in 4 ms


@pytest.mark.parametrize("joint", range(4))
@pytest.mark.parametrize(
    ("first", "then", "violations"), [(0.010, 0.030, 0), (0.011, 0.022, 1), (0.010, 0.031, 1), (-0.010, -0.031, 1)]
)
def test_jerk(joint, first, then, violations):
    watch = Watch()
    velocity = np.zeros(4)
    for velocity[joint] in (0, 0, first, then):
        seen = watch.command(list(velocity))
    assert seen == violations


def test_jerk_after_lost_frames():
    """After two lost frames, only the mean of the last three velocity changes is known. Here it is 18.3 mrad/s, the
    mean of 10, 20 and 25 mrad/s. The next change may differ from the mean by 10 (3 + 1) / 2 mrad/s."""
    for velocity, violations in ((0.055 + 0.025, 0), (0.055 - 0.001, 0), (0.055 - 0.002, 4)):
        watch = Watch()
        watch.command()
        watch.command()
        assert watch.command([0.055] * 4, ticks=3) == 0
        assert watch.command([velocity] * 4) == violations


@pytest.mark.parametrize("joint", range(4))
def test_each_joints_range(joint):
    low, high = np.radians([[-90, 150], [-95, 0], [-90, 90], [-114, 0]])[joint]
    for angle, violations in ((low, 0), (high, 0), (low - 5e-6, 1), (high + 5e-6, 1), (np.nan, 2)):
        position = [1.0, -0.5, 0.0, -1.0]
        position[joint] = angle
        assert Watch().command(position=position) == violations


def test_velocity_and_its_change():
    assert Watch().command([4.762, 0, 0, 0]) == 1  # the first frame has no change to check
    watch = Watch()
    watch.command()
    assert watch.command([0, 0.026, 0, 0]) == 1
    assert watch.command([0, 0.042, 0, 0]) == 1  # this change of 16 mrad/s is within the limit, so the count stays at 1
    assert watch.command([0, float("nan"), 0, 0]) > 1


def test_speed_fraction_in_force():
    watch = Watch(speed_fraction=0.1)
    for velocity in [*ramp(0.475), 0.47, 0.476]:
        assert watch.command([velocity, 0, 0, 0]) == 0
    assert watch.command([0.478, 0, 0, 0]) == 1


def test_speed_fraction_lowered_in_motion_leaves_time_to_brake():
    watch = Watch()
    for velocity in ramp(1.0):
        assert watch.command([0, -velocity, 0, 0]) == 0
    watch.speed_fraction = 0.1
    for slower in (0.01, 0.03, *(0.055 + 0.025 * np.arange(10))):
        assert watch.command([0, slower - velocity, 0, 0]) == 0
    assert watch.command([0, slower + 0.015 - velocity, 0, 0]) == 1, "above the new limit, it must brake fully"


def test_a_brake_closed_in_motion():
    watch = Watch()
    for step in range(10):
        assert watch.command([0.025 * step, 0, 0, 0]) == 0
    assert watch.command([0.225, 0, 0, 0], mode=(0, 1, 1, 1)) == 2, "both acceleration and jerk are violated"


def test_absent_joints_must_be_commanded_to_zero():
    assert Watch().command(extra=0.001) == 1


def test_a_frame_that_cannot_be_decoded():
    watch = Watch()
    lib.limit_monitor_undecodable(watch.monitor, 0)
    assert watch.monitor.violations == 1


@pytest.mark.parametrize(
    ("function", "message", "signal"),
    [
        ("mode_name", "FirmwareStatus", "mode"),
        ("reason_name", "FirmwareStatus", "reason"),
        ("task_name", "FirmwareStatus", "task"),
        ("command_name", "CommandAck", "command"),
        ("result_name", "CommandAck", "result"),
    ],
)
def test_names_match_the_dbc(dbc, function, message, signal):
    choices = dbc.get_message_by_name(message).get_signal_by_name(signal).choices
    for value in range(max(choices) + 3):
        expected = str(choices.get(value, "unknown"))
        assert ffi.string(getattr(lib, function)(value)).decode() == expected
