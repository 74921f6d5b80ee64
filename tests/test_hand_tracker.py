"""Checks the firmware's handling of tracker poses: age across two wrapping clocks, staleness, late frames, sign
continuity and interpolation."""

from __future__ import annotations

import numpy as np
import oracle
import pytest
from comanip._core import ffi, lib

WRAP = 2**32
PERIOD_US = 4000
NO_POSE_AGE = WRAP - 1
# (tracker's clock, firmware's clock) at the first pose: arbitrary values, and values at which either or both wrap soon
CLOCKS = [(0, 0), (123, 4_000_000_000), (WRAP - 10_000, 5000), (5000, WRAP - 10_000), (WRAP - 9_000, WRAP - 11_000)]


class Tracker:
    """Feeds poses to the firmware's hand_tracker. Times count from the first pose and are converted to the tracker's
    and to the firmware's clock."""

    def __init__(self, clocks=(0, 0)):
        self.stamp_zero, self.now_zero = clocks
        self.state = ffi.new("hand_tracker_t *")
        lib.hand_tracker_init(self.state, PERIOD_US)

    def now(self, t_us: int) -> int:
        return (self.now_zero + t_us) % WRAP

    def receive(
        self, measured_us: int, received_us: int, x_m=0.0, rotation=(1, 0, 0, 0), valid=True, taken_us=None
    ) -> bool:
        pose = ffi.new(
            "hand_pose_t *",
            {
                "t_us": (self.stamp_zero + measured_us) % WRAP,
                "position_m": {"x": x_m},
                "rotation": dict(zip("wxyz", map(float, rotation), strict=True)),
                "valid": valid,
            },
        )
        accepted = received_us if taken_us is None else taken_us
        return lib.hand_tracker_receive(self.state, pose, self.now(received_us), self.now(accepted))

    def announce(self, period_us: int) -> None:
        lib.hand_tracker_status(self.state, ffi.new("tracker_status_t *", {"period_us": period_us}))

    def age(self, t_us: int) -> int:
        return lib.hand_tracker_age_us(self.state, self.now(t_us))

    def is_stale(self, t_us: int, periods: float = 2.5) -> bool:
        return lib.hand_tracker_check_stale(self.state, self.now(t_us), periods)

    def pose(self, t_us: int) -> np.ndarray:
        result = ffi.new(
            "dual_quaternion_t *", lib.pose_to_dual_quaternion(lib.hand_tracker_pose(self.state, self.now(t_us)))
        )
        return np.frombuffer(ffi.buffer(result), np.float32).copy()


# ---- without interpolation


def test_after_switching_it_interpolates_from_the_current_pose():
    """When interpolation is switched on, it starts from the current pose and not from an older one."""
    tracker = Tracker()
    tracker.receive(0, 0, x_m=0.1)
    tracker.receive(4000, 4000, x_m=0.2)
    lib.hand_tracker_interpolate(tracker.state, False)
    assert oracle.translation(tracker.pose(4100))[0] == pytest.approx(0.2, abs=1e-6)
    tracker.receive(8000, 8000, x_m=0.5)
    assert oracle.translation(tracker.pose(8000))[0] == pytest.approx(0.5, abs=1e-6)
    lib.hand_tracker_interpolate(tracker.state, True)
    for t_us in (8100, 10_000):
        assert oracle.translation(tracker.pose(t_us))[0] == pytest.approx(0.5, abs=1e-6)
    lib.hand_tracker_interpolate(tracker.state, True)  # already on, so this has no effect
    tracker.receive(12_000, 12_000, x_m=0.6)
    lib.hand_tracker_interpolate(tracker.state, True)
    assert oracle.translation(tracker.pose(14_000))[0] == pytest.approx(0.55, abs=1e-6)


# ---- age


def test_without_a_pose_there_is_no_age():
    tracker = Tracker()
    assert tracker.age(0) == tracker.age(12345) == NO_POSE_AGE
    assert tracker.is_stale(0)


@pytest.mark.parametrize("clocks", CLOCKS, ids=str)
def test_age_is_time_since_reception_plus_how_late_the_frame_came(clocks):
    """Each frame takes at least 700 us from measurement to reception. If a frame took 900 us longer, its pose counts as
    900 us older."""
    tracker = Tracker(clocks)
    for i in range(20):
        extra_us = 900 if i % 5 == 4 else 0
        measured_us = i * PERIOD_US
        received_us = measured_us + 700 + extra_us
        assert tracker.receive(measured_us, received_us)
        for later_us in (0, 300, 2500):
            # the firmware raises the minimum clock offset by 1 us per 5 ms to allow for drift
            assert tracker.age(received_us + later_us) == pytest.approx(
                later_us + extra_us, abs=1 + i * PERIOD_US / 5000
            )


@pytest.mark.parametrize("clocks", CLOCKS, ids=str)
def test_a_slow_first_frame_is_corrected_by_the_first_fast_one(clocks):
    tracker = Tracker(clocks)
    assert tracker.receive(0, 5000)
    assert tracker.receive(PERIOD_US, PERIOD_US + 700)
    assert tracker.age(PERIOD_US + 700) == 0
    assert tracker.receive(2 * PERIOD_US, 2 * PERIOD_US + 1700)
    assert tracker.age(2 * PERIOD_US + 1700) == pytest.approx(1000, abs=2)


@pytest.mark.parametrize("drift_ppm", [-100, 100])
def test_clocks_that_drift_apart_do_not_age_the_poses(drift_ppm):
    """While two quartz clocks drift apart for ten minutes, the reported age stays within 2 us of the true age of the
    pose."""
    tracker = Tracker()
    for i in range(150_000):
        measured_us = i * PERIOD_US
        received_us = round(measured_us * (1 + drift_ppm * 1e-6)) + 700
        assert tracker.receive(measured_us, received_us)
        assert tracker.age(received_us) <= 2


# ---- staleness


@pytest.mark.parametrize("clocks", CLOCKS, ids=str)
@pytest.mark.parametrize("period_us", [1000, 4000, 66_660])
def test_stale_after_two_and_a_half_of_the_trackers_own_periods(clocks, period_us):
    tracker = Tracker(clocks)
    tracker.announce(period_us)
    assert tracker.receive(0, 700)
    limit_us = 700 + int(2.5 * period_us)
    assert not tracker.is_stale(limit_us - 1)
    assert tracker.is_stale(limit_us + 1)


def test_before_the_announcement_the_dbcs_period_applies(dbc):
    tracker = Tracker()
    assert tracker.receive(0, 0)
    limit_us = int(2.5e3 * dbc.get_message_by_name("HandPose").cycle_time)
    assert not tracker.is_stale(limit_us - 1)
    assert tracker.is_stale(limit_us + 1)


def test_a_period_of_zero_is_ignored():
    tracker = Tracker()
    tracker.announce(0)
    assert tracker.receive(0, 0)
    assert not tracker.is_stale(PERIOD_US)


def test_a_frame_that_came_too_late_is_stale_on_arrival():
    tracker = Tracker()
    assert tracker.receive(0, 700)
    assert tracker.receive(PERIOD_US, PERIOD_US + 700 + 12_000)
    assert tracker.is_stale(PERIOD_US + 700 + 12_000)


def test_invalid_poses_do_not_count_as_fresh():
    tracker = Tracker()
    assert tracker.receive(0, 0)
    for i in range(1, 10):
        assert not tracker.receive(i * PERIOD_US, i * PERIOD_US, valid=False)
    assert tracker.is_stale(9 * PERIOD_US)


@pytest.mark.parametrize("silence_us", [WRAP // 2 + 1000, WRAP - 1, WRAP, WRAP + 3000, 2 * WRAP + 100])
def test_a_pose_does_not_become_fresh_again_when_the_clock_wraps(silence_us):
    """A stale pose stays stale when the firmware's 32-bit clock in us wraps, after 71 minutes. The firmware checks the
    age in every tick, this test every 10 s."""
    tracker = Tracker()
    assert tracker.receive(0, 0)
    for t_us in range(10_000_000, silence_us, 10_000_000):
        assert tracker.is_stale(t_us)
    assert tracker.is_stale(silence_us)


@pytest.mark.parametrize("absence_min", [1, 40, 70])
def test_a_person_who_returns_after_a_break_is_accepted(absence_min):
    """A person is accepted again after a break in which the tracker sent only invalid poses."""
    tracker = Tracker()
    assert tracker.receive(0, 0)
    end_us = absence_min * 60_000_000
    for t_us in range(0, end_us, 1_000_000):
        assert not tracker.receive(t_us, t_us, valid=False)
        tracker.is_stale(t_us)
    assert tracker.receive(end_us, end_us)
    assert not tracker.is_stale(end_us + 1000)


def test_a_tracker_that_restarts_its_clock_is_accepted_again():
    """A restarted tracker stamps its frames from 0 again. The firmware accepts the new stream once the old pose has
    been stale for a second."""
    tracker = Tracker((100_000_000, 0))
    assert tracker.receive(0, 0)
    for t_us in range(0, 1_100_000, 1000):  # once per tick
        assert tracker.is_stale(t_us) == (t_us > 2.5 * PERIOD_US)
    restarted = [tracker.receive(i * PERIOD_US - 100_000_000, 1_100_000 + i * PERIOD_US) for i in range(20)]
    assert all(restarted)
    assert not tracker.is_stale(1_100_000 + 19 * PERIOD_US + 1000)


# ---- refusals


def test_late_and_repeated_frames_are_refused():
    tracker = Tracker()
    assert tracker.receive(PERIOD_US, PERIOD_US, x_m=1.0)
    assert not tracker.receive(0, PERIOD_US + 100, x_m=2.0)
    assert not tracker.receive(PERIOD_US, PERIOD_US + 200, x_m=3.0)
    assert oracle.translation(tracker.pose(10 * PERIOD_US))[0] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("norm", "accepted"), [(1.0, True), (0.9995, True), (1.0005, True), (0.998, False), (1.002, False), (0, False)]
)
def test_only_unit_quaternions_are_accepted(norm, accepted):
    tracker = Tracker()
    assert tracker.receive(0, 0, rotation=norm * oracle.rotation([1, 2, 3], 1.0)) == accepted


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_quaternion_that_is_not_finite_is_refused(bad):
    assert not Tracker().receive(0, 0, rotation=(1, bad, 0, 0))


# ---- the path between samples


def test_the_newest_sample_is_reached_after_one_period_and_kept():
    tracker = Tracker()
    tracker.receive(0, 0, x_m=0.0)
    tracker.receive(PERIOD_US, PERIOD_US, x_m=0.01)
    x = [oracle.translation(tracker.pose(PERIOD_US + t))[0] for t in (0, 1000, 2000, 3000, 4000, 9000)]
    assert x == pytest.approx([0, 0.0025, 0.005, 0.0075, 0.01, 0.01], abs=1e-7)


@pytest.mark.parametrize("period_us", [4000, 16_670, 66_660])
def test_the_path_is_continuous_even_if_samples_jitter(rng, period_us):
    """If the interpolated position is read at 1 kHz, it never moves further in a step than the hand's speed allows,
    apart from a margin for the jitter of the samples."""
    tracker, speed = Tracker(), 0.5
    tracker.announce(period_us)
    path, i, received_us = [], 0, 0
    for t_us in range(0, 60 * period_us, 1000):
        while received_us <= t_us:
            tracker.receive(i * period_us, received_us, x_m=speed * 1e-6 * i * period_us, taken_us=t_us)
            i += 1
            received_us = i * period_us + int(rng.integers(0, period_us // 4))
        path.append(oracle.translation(tracker.pose(t_us))[0])
    steps = np.diff(path)
    assert steps.min() >= -1e-6
    assert steps.max() < 2 * speed * 1e-3


def test_flipped_signs_change_nothing(rng):
    """The tracker may send either q or -q at any time. The interpolated path stays the same, and the sign of its
    quaternions never flips."""
    rotations = [oracle.rotation([1, 2, 3], angle) for angle in np.linspace(0, 4 * np.pi, 200)]
    steady, flipped = Tracker(), Tracker()
    last = None
    for i, rotation in enumerate(rotations):
        sign = -1 if rng.random() < 0.5 else 1
        now_us = i * PERIOD_US
        steady.receive(now_us, now_us, rotation=rotation)
        flipped.receive(now_us, now_us, rotation=sign * rotation)
        for t_us in range(now_us, now_us + PERIOD_US, 1000):
            one, other = steady.pose(t_us), flipped.pose(t_us)
            assert oracle.pose_distance(one, other) < 1e-6
            if last is not None:
                assert np.abs(other - last).max() < 0.1
            last = other


def test_interpolated_poses_are_unit(rng):
    tracker = Tracker()
    for i, rotation in enumerate(oracle.random_rotations(rng, 200)):
        tracker.receive(i * PERIOD_US, i * PERIOD_US, x_m=float(rng.uniform(-1, 1)), rotation=rotation)
        for t_us in range(i * PERIOD_US, (i + 1) * PERIOD_US, 700):
            pose = tracker.pose(t_us)
            assert np.abs(pose - oracle.unit(pose)).max() < 1e-6
