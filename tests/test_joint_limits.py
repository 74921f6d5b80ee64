"""Checks that the joint limits keep position, velocity, acceleration and jerk of every command within bounds."""

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
RESOLUTION_RADPS = 1e-3  # resolution of the velocity in JointCmd

any_velocity = st.one_of(
    st.floats(-10, 10),
    st.sampled_from([0.0, 1e6, -1e6, 3e38, -3e38, math.nan, math.inf, -math.inf]),
    st.floats(width=32),
)
commands = st.lists(
    st.tuples(st.lists(any_velocity, min_size=N, max_size=N), st.integers(1, 400)), min_size=1, max_size=8
)
fractions = st.lists(st.floats(0, 1), min_size=N, max_size=N)


IDENTITY, Z_AXIS = np.array([[1, 0, 0, 0, 0, 0, 0, 0]], np.float32), np.array([[0, 0, 1]], np.float32)
DEFAULT_JERK = 10_000.0


def arm_of(jerk: float) -> core.Arm:
    """Returns an arm with HOAP-3's ranges and speeds, and with the given jerk limit."""
    ranges = (ARM.position_min_rad, ARM.position_max_rad, ARM.velocity_max_radps)
    return core.Arm(
        np.repeat(IDENTITY, N, 0), np.repeat(Z_AXIS, N, 0), *ranges, jerk_max_radps3=np.full(N, jerk, np.float32)
    )


class Drives:
    """Joints that follow commands with a first-order lag. A command takes effect `delay_ticks` after the tick that read
    the positions from which the command was computed."""

    def __init__(
        self, position_rad, delay_ticks: int, acceleration=25.0, jerk=DEFAULT_JERK, lag_s=0.0, tick_s=TICK_S, **config
    ):
        self.position_rad, self.velocity_radps = np.array(position_rad, float), np.zeros(N)
        self.pipe = deque([np.zeros(N)] * delay_ticks)
        self.lag_s, self.tick_s = lag_s, tick_s
        self.arm = arm_of(jerk)
        self.state = ffi.new("joint_limits_t *")
        lib.joint_limits_init(self.state)
        self.config = ffi.new(
            "joint_limits_config_t *",
            {"tick_s": tick_s, "speed_fraction": 1.0, "acceleration_max_radps2": acceleration, "command_delay_s": 0.005}
            | {"approach_gain_per_s": 100.0}
            | config,
        )
        lib.joint_limits_prepare(self.config, self.arm.table)

    def tick(self, demanded, measured=None, feedforward=()) -> tuple[bool, np.ndarray]:
        measured = self.position_rad if measured is None else measured
        finite = lib.joint_limits_apply(
            self.state,
            self.arm.table,
            self.config,
            *(ffi.new("float[8]", list(x)) for x in (measured, demanded, feedforward)),
        )
        velocity = np.array(list(self.state.velocity_radps)[:N])
        self.pipe.append(velocity)
        self._move(self.pipe.popleft())
        return finite, velocity

    def _move(self, commanded) -> None:
        left = math.exp(-self.tick_s / self.lag_s) if self.lag_s else 0.0
        self.position_rad += self.tick_s * commanded + self.lag_s * (1 - left) * (self.velocity_radps - commanded)
        self.velocity_radps = commanded + left * (self.velocity_radps - commanded)

    @property
    def at_rest(self) -> bool:
        return lib.joint_limits_at_rest(self.state, self.arm.table)


class Judge:
    """Checks each commanded velocity, and its first and second differences in float64, against the limits."""

    def __init__(self, speed_max, acceleration: float, jerk: float, tick_s: float):
        self.velocity, self.change = np.zeros(N), np.zeros(N)
        self.speed_max, self.change_max, self.second_max = speed_max, acceleration * tick_s, jerk * tick_s**2

    def __call__(self, velocity) -> None:
        change = velocity - self.velocity
        assert np.isfinite(velocity).all()
        assert (np.abs(velocity) <= self.speed_max + 2e-6).all()
        assert (np.abs(change) <= self.change_max + 2e-6).all()
        assert (np.abs(change - self.change) <= self.second_max + 4e-6).all()
        self.velocity, self.change = velocity, change


def position_at(fraction) -> np.ndarray:
    return ARM.position_min_rad + np.array(fraction) * (ARM.position_max_rad - ARM.position_min_rad)


ticks_s = st.sampled_from([1e-3, 4e-3])
accelerations, jerks = st.floats(1, 70), st.floats(1e3, 1e6)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(
    start=fractions,
    commanded=commands,
    delay_ticks=st.integers(0, 5),
    acceleration=accelerations,
    jerk=jerks,
    fraction=st.floats(0.01, 1),
)
def test_no_limit_is_ever_exceeded(start, commanded, delay_ticks, acceleration, jerk, fraction):
    drives = Drives(position_at(start), delay_ticks, acceleration, jerk, speed_fraction=fraction)
    judge = Judge(fraction * ARM.velocity_max_radps, acceleration, jerk, TICK_S)
    for demanded, ticks in commanded:
        for _ in range(ticks):
            finite, velocity = drives.tick(demanded)
            assert finite == bool(np.isfinite(np.array(demanded, np.float32)).all())
            judge(velocity)
            reference = np.array(list(drives.state.position_rad)[:N])
            assert ((reference >= ARM.position_min_rad) & (reference <= ARM.position_max_rad)).all()
            assert (drives.position_rad >= ARM.position_min_rad - 1e-6).all()
            assert (drives.position_rad <= ARM.position_max_rad + 1e-6).all()


LONGEST_HOLD = {"a tick": 1, "some ticks": 30, "until it is there": 500}
LAG_AS_DELAY = (
    1.42  # sqrt(2): a delay adds v delay + a delay^2 / 2 to the stopping distance, and a lag adds v lag + a lag^2
)


@pytest.mark.parametrize("hold", LONGEST_HOLD)
@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32), tick_s=ticks_s, delay_ticks=st.integers(0, 3),
       lag_s=st.one_of(st.just(0.0), st.floats(1e-3, 1e-2)),
       acceleration=accelerations, jerk=jerks)  # fmt: skip
def test_bang_bang_at_the_ends_of_the_range(hold, seed, tick_s, delay_ticks, lag_s, acceleration, jerk):
    """No limit is exceeded when a high speed is demanded for random times, mostly outwards, together with a random
    feedforward velocity. Some of the demands are NaN."""
    rng = np.random.default_rng(seed)
    start = position_at(rng.random(N) ** 3 if seed % 2 else 1 - rng.random(N) ** 3)
    delay_s = delay_ticks * tick_s + LAG_AS_DELAY * lag_s
    drives = Drives(start, delay_ticks, acceleration, jerk, lag_s, tick_s, command_delay_s=delay_s)
    judge = Judge(ARM.velocity_max_radps, acceleration, jerk, tick_s)
    outwards = np.where(drives.position_rad > position_at([0.5] * N), 1.0, -1.0)
    left, demanded = np.zeros(N, int), np.zeros(N)
    for _ in range(500):
        again = left <= 0
        demanded[again] = (outwards * rng.choice([10.0, 1.0, -10.0, math.nan], N, p=[0.7, 0.1, 0.19, 0.01]))[again]
        left[again] = rng.integers(0, LONGEST_HOLD[hold], N)[again]
        left -= 1
        judge(drives.tick(demanded, feedforward=rng.uniform(-5, 5, N))[1])
        assert (drives.position_rad >= ARM.position_min_rad - 1e-6).all()
        assert (drives.position_rad <= ARM.position_max_rad + 1e-6).all()


@settings(max_examples=100, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32), tick_s=ticks_s, acceleration=accelerations, jerk=jerks, commanded=commands)
def test_a_joint_stops_in_time(seed, tick_s, acceleration, jerk, commanded):
    """The joints stop from any state, in most examples from full acceleration, within v/a + 2.5 a/j plus two ticks,
    where a and j are rounded down to whole steps of the resolution. The brakes may engage only after the stop."""
    drives = Drives(position_at([0.5] * N), 0, acceleration, jerk, tick_s=tick_s, approach_gain_per_s=0.0)
    change_max = math.floor(acceleration * tick_s / RESOLUTION_RADPS + 1e-3)
    second_max = math.floor(jerk * tick_s**2 / RESOLUTION_RADPS + 1e-3)
    rng = np.random.default_rng(seed)
    judge = Judge(ARM.velocity_max_radps, acceleration, jerk, tick_s)
    for demanded, ticks in commanded:
        for _ in range(1 + ticks // rng.integers(1, 20)):
            judge(drives.tick(demanded, position_at([0.5] * N))[1])
        saved = ffi.new("joint_limits_t *", drives.state[0])
        steps = np.abs(judge.velocity).max() / RESOLUTION_RADPS
        for _ in range(math.floor(steps / change_max + 2.5 * change_max / second_max + 2)):
            drives.tick([0.0] * N, position_at([0.5] * N))
        assert drives.at_rest
        assert not any(drives.state.velocity_radps)
        drives.state[0] = saved[0]


def test_a_joint_that_passes_zero_is_not_at_rest():
    """A joint whose velocity passes through 0 is not at rest: the velocity is still changing, so engaging the brakes
    would exceed the jerk limit."""
    drives = Drives(position_at([0.5] * N), 0, approach_gain_per_s=0.0)
    for demanded in (0.1, -0.1):
        seen = [(drives.tick([demanded] * N, position_at([0.5] * N))[1][0], drives.at_rest) for _ in range(40)]
    assert any(abs(velocity) < 0.03 for velocity, _ in seen)
    assert not any(at_rest for _, at_rest in seen)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(start=fractions, demanded=st.lists(st.floats(-5, 5), min_size=N, max_size=N), acceleration=st.floats(1, 70))
def test_commands_are_whole_multiples_of_the_bus_resolution(start, demanded, acceleration):
    drives = Drives(position_at(start), 2, acceleration)
    for _ in range(100):
        steps = drives.tick(demanded)[1] / RESOLUTION_RADPS
        assert np.abs(steps - np.round(steps)).max() < 1e-3


@pytest.mark.parametrize("acceleration", [1.0, 1.5, 5.0, 25.0, 70.0])
def test_any_demanded_speed_is_reached_and_left_again(acceleration):
    """The demanded speed is reached within the time that acceleration and jerk allow, both in whole steps of the
    resolution. No part of the speed is lost to rounding."""
    drives = Drives(position_at([0.5] * N), 0, acceleration, approach_gain_per_s=0.0)
    target = np.array([0.4, -0.3, 0.2, -0.1])
    steps_a_tick = math.floor(acceleration * TICK_S / RESOLUTION_RADPS + 1e-6)
    ticks = math.ceil(0.4 / (steps_a_tick * RESOLUTION_RADPS)) + math.ceil(2.5 * steps_a_tick / 10) + 2
    for _ in range(ticks):
        velocity = drives.tick(target)[1]
        drives.position_rad = position_at([0.5] * N)
    assert np.abs(velocity - target).max() < 1.5 * RESOLUTION_RADPS
    for _ in range(ticks):
        drives.tick([0.0] * N)
    assert drives.at_rest


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("where", ["demanded", "measured", "feedforward"])
def test_a_non_finite_demand_brakes(bad, where):
    drives = Drives(position_at([0.5] * N), 0)
    for _ in range(50):
        drives.tick([1.0, -1.0, 0.5, 1.0])
    spoilt = [0.5, bad, 0.0, 0.0]
    speed = np.abs(list(drives.state.velocity_radps)[:N])
    for _ in range(60):
        finite, velocity = drives.tick(**{"demanded": [1.0] * N} | {where: spoilt})
        assert not finite
        assert (np.abs(velocity) <= speed).all()
        assert np.isfinite(list(drives.state.position_rad)).all()
        speed = np.abs(velocity)
    assert drives.at_rest


@settings(max_examples=100, deadline=None, derandomize=True)
@given(demanded=st.lists(st.floats(-50, 50), min_size=N, max_size=N))
def test_speed_limits_keep_the_direction(demanded):
    """If only the speed limits act, the velocities of all joints are scaled by the same factor, so that the most
    constrained joint moves exactly at its limit."""
    drives = Drives(position_at([0.5] * N), 0, acceleration=70, command_delay_s=0.0, approach_gain_per_s=0.0)
    for _ in range(100):
        velocity = drives.tick(demanded, position_at([0.5] * N))[1]
    share = min(1.0, *(limit / max(abs(w), 1e-9) for limit, w in zip(ARM.velocity_max_radps, demanded, strict=True)))
    assert np.abs(velocity - share * np.array(demanded)).max() < 1.5 * RESOLUTION_RADPS


@settings(max_examples=50, deadline=None, derandomize=True)
@given(
    error=st.lists(st.floats(-6, 6), min_size=N, max_size=N),
    feedforward=st.lists(st.floats(-6, 6), min_size=N, max_size=N),
    gain=st.floats(10, 200),
)
def test_feedforward_is_not_reduced_for_the_stopping_distance(error, feedforward, gain):
    """The part of the demand that corrects the error is reduced to the speed from which the joint can still stop where
    the error is zero. The feedforward is added without this reduction, and the sum is scaled to the speed limit."""
    drives = Drives(position_at([0.5] * N), 0, approach_gain_per_s=gain, command_delay_s=0.0)
    error, feedforward = np.array(error), np.array(feedforward)
    linear = 0.9 * 25.0 / gain
    braked = [math.sqrt(linear * (2 * speed - linear)) / speed for speed in np.abs(error) if speed > linear]
    commanded = min([1.0, *braked]) * error + feedforward
    expected = commanded * min(1.0, *(ARM.velocity_max_radps / np.maximum(np.abs(commanded), 1e-9)))
    for _ in range(300):
        velocity = drives.tick(error, position_at([0.5] * N), feedforward)[1]
    assert np.abs(velocity - expected).max() < 1.5 * RESOLUTION_RADPS


def test_a_sum_that_overflows_brakes():
    finite, velocity = Drives(position_at([0.5] * N), 0, approach_gain_per_s=0.0).tick([3e38] * N, None, [3e38] * N)
    assert not finite
    assert (velocity == 0).all()


@pytest.mark.parametrize(("gain", "overshoot_rad"), [(35.0, 1e-5), (100.0, 2e-3)])
@pytest.mark.parametrize("delay_ticks", [0, 2])
@pytest.mark.parametrize("way_rad", [0.001, 0.05, 0.5, 1.2])
def test_a_proportional_law_arrives_without_overshoot(gain, overshoot_rad, delay_ticks, way_rad):
    """With a demand of K times the distance, a joint brakes in time although the control law does not know the limits.
    At a gain of 100/s the joint overshoots by up to 2 mrad, because it enters the linear range while still
    accelerating."""
    drives = Drives(position_at([0.5] * N), delay_ticks, command_delay_s=0.002, approach_gain_per_s=gain)
    start = drives.position_rad.copy()
    goal = start + way_rad * np.array([1, -1, 1, -1]) * [1, 0.5, 0.7, 0.3]
    for _ in range(1500):
        drives.tick(gain * (goal - drives.position_rad))
        assert (np.abs(drives.position_rad - start) <= np.abs(goal - start) + overshoot_rad).all()
    assert np.abs(drives.position_rad - goal).max() < 0.5 * RESOLUTION_RADPS / gain + 1e-5


@pytest.mark.parametrize("outside_rad", [0.001, 0.1])
def test_a_joint_outside_its_range_may_only_return(outside_rad):
    drives = Drives(position_at([1] * N) + outside_rad, 0)
    for _ in range(20):
        assert (drives.tick([1.0] * N)[1] <= 0).all()
    for _ in range(1000):
        drives.tick([-0.5] * N)
    assert (drives.position_rad < ARM.position_max_rad).all()


AT_LIMIT_RAD = 2e-3  # the same as JOINT_LIMITS_AT_LIMIT_RAD
BRAKING, RAMP = 0.9 * 25.0, (0.9 * 25.0) ** 2 / (2 * DEFAULT_JERK)
# a joint that is nearer to its limit than this and moves towards it cannot stop in time, however slow it is
NEAR_END_RAD = AT_LIMIT_RAD + ((2 * RAMP + BRAKING * (0.005 + TICK_S)) ** 2 - RAMP**2) / (2 * BRAKING)


@pytest.mark.parametrize("end", ["low", "high"])
@pytest.mark.parametrize(
    ("inside_rad", "is_there"),
    [(NEAR_END_RAD - 2e-6, True), (NEAR_END_RAD + 2e-6, False), (0, True), (-0.01, True), (0.1, False)],
)
def test_which_joints_are_at_a_limit(end, inside_rad, is_there):
    config = Drives(position_at([0.5] * N), 0).config
    for joint in range(N):
        measured = position_at([0.5] * N)
        measured[joint] = position_at([float(end == "high")] * N)[joint] + (
            -inside_rad if end == "high" else inside_rad
        )
        at_limit = lib.joints_at_limit_find(ARM.table, config.at_limit_rad, ffi.new("float[8]", list(measured)))
        there = 1 << joint if is_there else 0
        assert (at_limit.lower, at_limit.upper) == ((0, there) if end == "high" else (there, 0))


def test_a_joint_of_a_narrow_range_is_at_both_limits():
    limit = np.full(1, 1e-3, np.float32)
    arm = core.Arm(IDENTITY, Z_AXIS, -limit, limit, np.ones(1, np.float32))
    config = Drives(position_at([0.5] * N), 0).config  # provides at_limit_rad
    at_limit = lib.joints_at_limit_find(arm.table, config.at_limit_rad, ffi.new("float[8]"))
    assert (at_limit.lower, at_limit.upper) == (1, 1)
