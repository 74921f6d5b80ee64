"""The only way out to a command: whatever is asked, position, velocity and acceleration stay within limits."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
import pytest
from comanip import core
from comanip._core import ffi, lib
from hypothesis import given, settings
from hypothesis import strategies as st

ARM = core.Arm.named("hoap3_right")
N = ARM.joint_count
TICK_S = 1e-3
RESOLUTION_RADPS = 1e-3  # of JointCmd's velocity

any_velocity = st.one_of(
    st.floats(-10, 10), st.sampled_from([0.0, 1e6, -1e6, 3e38, -3e38, math.nan, math.inf, -math.inf]), st.floats(width=32)
)
commands = st.lists(st.tuples(st.lists(any_velocity, min_size=N, max_size=N), st.integers(1, 400)), min_size=1, max_size=8)
fractions = st.lists(st.floats(0, 1), min_size=N, max_size=N)


class PerfectDrives:
    """Joints that do exactly what is commanded, `delay_ticks` after the tick that saw their position."""

    def __init__(self, position_rad, delay_ticks: int, acceleration: float = 25.0, **config):
        self.position_rad = np.array(position_rad, float)
        self.pipe = deque([np.zeros(N)] * delay_ticks)
        self.state = ffi.new("joint_limits_t *")
        lib.joint_limits_init(self.state)
        self.config = ffi.new(
            "joint_limits_config_t *",
            {"tick_s": TICK_S, "speed_fraction": 1.0, "acceleration_max_radps2": acceleration, "command_delay_s": 0.005}
            | {"approach_gain_per_s": 100.0}
            | config,
        )
        lib.joint_limits_prepare(self.config)

    def tick(self, wanted, measured=None, feedforward=()) -> tuple[bool, np.ndarray]:
        measured = self.position_rad if measured is None else measured
        finite = lib.joint_limits_apply(
            self.state, ARM.table, self.config, *(ffi.new("float[8]", list(x)) for x in (measured, wanted, feedforward))
        )
        velocity = np.array(list(self.state.velocity_radps)[:N])
        self.pipe.append(velocity)
        self.position_rad += TICK_S * self.pipe.popleft()
        return finite, velocity


def position_at(fraction) -> np.ndarray:
    return ARM.position_min_rad + np.array(fraction) * (ARM.position_max_rad - ARM.position_min_rad)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(start=fractions, asked=commands, delay_ticks=st.integers(0, 5), acceleration=st.floats(1, 70), fraction=st.floats(0.01, 1))
def test_no_limit_is_ever_exceeded(start, asked, delay_ticks, acceleration, fraction):
    drives = PerfectDrives(position_at(start), delay_ticks, acceleration, speed_fraction=fraction)
    speed_limit = fraction * ARM.velocity_max_radps
    last = np.zeros(N)
    for wanted, ticks in asked:
        for _ in range(ticks):
            finite, velocity = drives.tick(wanted)
            assert finite == bool(np.isfinite(np.array(wanted, np.float32)).all())
            assert np.isfinite(velocity).all()
            assert (np.abs(velocity) <= speed_limit + 2e-6).all()
            assert (np.abs(velocity - last) <= acceleration * TICK_S + 2e-6).all()
            last = velocity
            reference = np.array(list(drives.state.position_rad)[:N])
            assert ((reference >= ARM.position_min_rad) & (reference <= ARM.position_max_rad)).all()
            assert (drives.position_rad >= ARM.position_min_rad - 1e-6).all()
            assert (drives.position_rad <= ARM.position_max_rad + 1e-6).all()


@settings(max_examples=50, deadline=None, derandomize=True)
@given(start=fractions, wanted=st.lists(st.floats(-5, 5), min_size=N, max_size=N), acceleration=st.floats(1, 70))
def test_commands_are_whole_multiples_of_the_bus_resolution(start, wanted, acceleration):
    drives = PerfectDrives(position_at(start), 2, acceleration)
    for _ in range(100):
        steps = drives.tick(wanted)[1] / RESOLUTION_RADPS
        assert np.abs(steps - np.round(steps)).max() < 1e-3


@pytest.mark.parametrize("acceleration", [1.0, 1.5, 5.0, 25.0, 70.0])
def test_any_speed_wanted_is_reached_and_left_again(acceleration):
    """Within the time that the acceleration allows, in whole steps of the resolution: none is lost to rounding."""
    drives = PerfectDrives(position_at([0.5] * N), 0, acceleration, approach_gain_per_s=0.0)
    target = np.array([0.4, -0.3, 0.2, -0.1])
    steps_a_tick = math.floor(acceleration * TICK_S / RESOLUTION_RADPS + 1e-6)
    ticks = math.ceil(0.4 / (steps_a_tick * RESOLUTION_RADPS)) + 2
    for _ in range(ticks):
        velocity = drives.tick(target)[1]
        drives.position_rad = position_at([0.5] * N)
    assert np.abs(velocity - target).max() < 1.5 * RESOLUTION_RADPS
    for _ in range(ticks):
        drives.tick([0.0] * N)
    assert lib.joint_limits_at_rest(drives.state, ARM.table)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("where", ["wanted", "measured", "feedforward"])
def test_what_is_not_finite_brakes(bad, where):
    drives = PerfectDrives(position_at([0.5] * N), 0)
    for _ in range(50):
        drives.tick([1.0, -1.0, 0.5, 1.0])
    spoilt = [0.5, bad, 0.0, 0.0]
    speed = np.abs(list(drives.state.velocity_radps)[:N])
    for _ in range(60):
        finite, velocity = drives.tick(**{"wanted": [1.0] * N} | {where: spoilt})
        assert not finite
        assert (np.abs(velocity) <= speed).all()
        assert np.isfinite(list(drives.state.position_rad)).all()
        speed = np.abs(velocity)
    assert lib.joint_limits_at_rest(drives.state, ARM.table)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(wanted=st.lists(st.floats(-50, 50), min_size=N, max_size=N))
def test_speed_limits_keep_the_direction(wanted):
    """Where only speed limits act, all joints are slowed alike, to the limit of one of them."""
    drives = PerfectDrives(position_at([0.5] * N), 0, acceleration=1e6, command_delay_s=0.0)
    velocity = drives.tick(wanted)[1]
    share = min(1.0, *(limit / max(abs(w), 1e-9) for limit, w in zip(ARM.velocity_max_radps, wanted, strict=True)))
    assert np.abs(velocity - share * np.array(wanted)).max() < 1.5 * RESOLUTION_RADPS


@settings(max_examples=50, deadline=None, derandomize=True)
@given(
    error=st.lists(st.floats(-6, 6), min_size=N, max_size=N),
    feedforward=st.lists(st.floats(-6, 6), min_size=N, max_size=N),
    gain=st.floats(10, 200),
)
def test_what_is_fed_forward_is_not_braked_for_the_way_to_go(error, feedforward, gain):
    """Only the error's share is: at the speed from which K times the way stops. The sum is held to the speed limit in proportion."""
    drives = PerfectDrives(position_at([0.5] * N), 0, approach_gain_per_s=gain, command_delay_s=0.0)
    error, feedforward = np.array(error), np.array(feedforward)
    linear = 0.9 * 25.0 / gain
    braked = [math.sqrt(linear * (2 * speed - linear)) / speed for speed in np.abs(error) if speed > linear]
    asked = min([1.0, *braked]) * error + feedforward
    expected = asked * min(1.0, *(ARM.velocity_max_radps / np.maximum(np.abs(asked), 1e-9)))
    for _ in range(300):
        velocity = drives.tick(error, position_at([0.5] * N), feedforward)[1]
    assert np.abs(velocity - expected).max() < 1.5 * RESOLUTION_RADPS


def test_a_sum_that_overflows_brakes():
    finite, velocity = PerfectDrives(position_at([0.5] * N), 0, approach_gain_per_s=0.0).tick([3e38] * N, None, [3e38] * N)
    assert not finite
    assert (velocity == 0).all()


@pytest.mark.parametrize("delay_ticks", [0, 2])
@pytest.mark.parametrize("way_rad", [0.001, 0.05, 0.5, 1.2])
def test_a_proportional_law_arrives_without_overshoot(delay_ticks, way_rad):
    """Asked for K times the way to go, a joint brakes in time although the law itself does not know the limits."""
    drives = PerfectDrives(position_at([0.5] * N), delay_ticks, command_delay_s=0.002)
    start = drives.position_rad.copy()
    goal = start + way_rad * np.array([1, -1, 1, -1]) * [1, 0.5, 0.7, 0.3]
    for _ in range(1500):
        drives.tick(100.0 * (goal - drives.position_rad))
        assert (np.abs(drives.position_rad - start) <= np.abs(goal - start) + 2e-4).all()
    assert np.abs(drives.position_rad - goal).max() < 2e-5


@pytest.mark.parametrize("outside_rad", [0.001, 0.1])
def test_a_joint_outside_its_range_may_only_return(outside_rad):
    drives = PerfectDrives(position_at([1] * N) + outside_rad, 0)
    for _ in range(20):
        assert (drives.tick([1.0] * N)[1] <= 0).all()
    for _ in range(1000):
        drives.tick([-0.5] * N)
    assert (drives.position_rad < ARM.position_max_rad).all()


AT_LIMIT_RAD = 2e-3  # JOINT_LIMITS_AT_LIMIT_RAD
NEAR_END_RAD = AT_LIMIT_RAD + 0.5 * 0.9 * 25.0 * (0.005 + TICK_S) ** 2  # and what is left of the way when a joint's stopping speed is 0


@pytest.mark.parametrize("end", ["low", "high"])
@pytest.mark.parametrize(("inside_rad", "stands_there"), [(NEAR_END_RAD - 2e-6, True), (NEAR_END_RAD + 2e-6, False), (0, True), (-0.01, True), (0.1, False)])
def test_which_joints_stand_at_an_end_of_their_range(end, inside_rad, stands_there):
    config = PerfectDrives(position_at([0.5] * N), 0).config
    for joint in range(N):
        measured = position_at([0.5] * N)
        measured[joint] = position_at([float(end == "high")] * N)[joint] + (-inside_rad if end == "high" else inside_rad)
        ends = lib.joint_limits_ends(ARM.table, config, ffi.new("float[8]", list(measured)))
        there = 1 << joint if stands_there else 0
        assert (ends.lower, ends.upper) == ((0, there) if end == "high" else (there, 0))


def test_a_joint_of_a_narrow_range_stands_at_both_ends():
    pose, axis, limit = np.array([[1, 0, 0, 0, 0, 0, 0, 0]], np.float32), np.array([[0, 0, 1]], np.float32), np.full(1, 1e-3, np.float32)
    arm = core.Arm(pose, axis, -limit, limit, np.ones(1, np.float32))
    ends = lib.joint_limits_ends(arm.table, PerfectDrives(position_at([0.5] * N), 0).config, ffi.new("float[8]"))
    assert (ends.lower, ends.upper) == (1, 1)
