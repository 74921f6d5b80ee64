"""The monitor of JointCmd frames finds each kind of violation, and none where there is none. And the names the simulator
prints are the DBC's."""

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
        message = ffi.new("joint_command_t *")
        for i in range(4):
            message.mode[i], message.position_rad[i], message.velocity_radps[i] = mode[i], position[i], velocity[i]
        if extra is not None:
            message.velocity_radps[6] = extra
        lib.limit_monitor_command(self.monitor, message, self.now_ns, self.speed_fraction, ACCELERATION)
        return self.monitor.violations


def test_a_ramp_at_the_limits_is_no_violation():
    watch = Watch()
    for step in range(0, 191):
        assert watch.command([min(0.025 * step, 4.76)] * 4) == 0
    assert watch.command([4.76 - 0.05] * 4, ticks=2) == 0  # a frame lost: twice the time, twice the change


@pytest.mark.parametrize("joint", range(4))
def test_each_joints_range(joint):
    low, high = np.radians([[-90, 150], [-95, 0], [-90, 90], [-114, 0]])[joint]
    for angle, violations in ((low, 0), (high, 0), (low - 5e-6, 1), (high + 5e-6, 1), (np.nan, 2)):
        position = [1.0, -0.5, 0.0, -1.0]
        position[joint] = angle
        assert Watch().command(position=position) == violations


def test_velocity_and_its_change():
    assert Watch().command([4.762, 0, 0, 0]) == 1  # the first frame has no change to judge
    watch = Watch()
    watch.command()
    assert watch.command([0, 0.026, 0, 0]) == 1
    assert watch.command([0, 0.001, 0, 0]) == 1  # back within the limit
    assert watch.command([0, float("nan"), 0, 0]) > 1


def test_speed_fraction_in_force():
    watch = Watch(speed_fraction=0.1)
    for step in range(1, 20):
        assert watch.command([0.025 * step, 0, 0, 0]) == 0
    assert watch.command([0.476, 0, 0, 0]) == 0
    assert watch.command([0.478, 0, 0, 0]) == 1


def test_speed_fraction_lowered_in_motion_leaves_time_to_brake():
    watch = Watch()
    for step in range(1, 41):
        assert watch.command([0, -0.025 * step, 0, 0]) == 0
    watch.speed_fraction = 0.1
    for step in range(39, 19, -1):
        assert watch.command([0, -0.025 * step, 0, 0]) == 0
    assert watch.command([0, -0.5, 0, 0]) == 1, "stays above the new limit"


def test_a_brake_closed_in_motion():
    watch = Watch()
    for step in range(10):
        assert watch.command([0.025 * step, 0, 0, 0]) == 0
    assert watch.command([0.225, 0, 0, 0], mode=(0, 1, 1, 1)) == 1


def test_joints_that_are_not_there_stand_still():
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
def test_names_are_the_dbcs(dbc, function, message, signal):
    choices = dbc.get_message_by_name(message).get_signal_by_name(signal).choices
    for value in range(max(choices) + 3):
        expected = str(choices.get(value, "unknown"))
        assert ffi.string(getattr(lib, function)(value)).decode() == expected
