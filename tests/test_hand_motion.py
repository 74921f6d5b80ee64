"""Checks the estimate of the hand's motion against motions in closed form, against the filter's equations in double
precision, and for properties that must hold for any motion."""

from __future__ import annotations

import numpy as np
import oracle
import pytest
from comanip._core import ffi, lib

WRAP = 2**32
TICK_US = 1000
GAP_S = lib.HAND_MOTION_GAP_S
RATES_HZ = [15, 30, 60, 90, 120, 250, 500]
X = np.array([1.0, 0.0, 0.0])
IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


def turn(axis, angle_rad) -> np.ndarray:
    return oracle.rotation(axis, angle_rad)


def still(_):
    return np.zeros(3), IDENTITY


def minimum_jerk(s):
    s = np.clip(s, 0, 1)
    return s**3 * (10 - 15 * s + 6 * s * s)


class Estimate:
    """The firmware's estimate of the hand's motion. Times in us are relative to `zero_us` on the firmware's clock."""

    def __init__(self, zero_us=0):
        self.zero_us = zero_us
        self.state = ffi.new("hand_motion_t *")
        lib.hand_motion_init(self.state)

    def sample(self, position, rotation, captured_us, now_us):
        w, x, y, z = (float(c) for c in rotation)
        px, py, pz = (float(c) for c in position)
        pose = ffi.new("pose_t *", {"rotation": (w, x, y, z), "translation_m": (px, py, pz)})
        lib.hand_motion_sample(self.state, pose, (self.zero_us + captured_us) % WRAP, (self.zero_us + now_us) % WRAP)

    def predict(self, now_us, ahead_s=0.0) -> np.ndarray:
        """Returns the predicted rotation (w x y z), position, velocity and angular velocity as one array."""
        arguments = (self.state, (self.zero_us + now_us) % WRAP, ahead_s)
        pose = ffi.new("pose_t *", lib.hand_motion_pose(*arguments))
        motion = ffi.new("twist_t *", lib.hand_motion_twist(*arguments))
        return np.concatenate([np.frombuffer(ffi.buffer(part), np.float32) for part in (pose, motion)]).astype(float)


def run(truth, duration_s, rate_hz=250, latency_s=0.004, noise_m=0.0, rng=None, ahead_s=0.0, estimate=None, **how):
    """Feeds samples of truth(t) -> (position, rotation) at a given rate to the estimate. Returns the time and the
    prediction at each tick.

    Options in `how`: lost(t) returns whether a sample is lost, change(position, rotation) modifies a sample,
    announced_s is the latency that the estimate assumes (default: the true latency_s), and jitter is the range of
    random shifts of the sampling times, as a share of the sampling interval.
    """
    estimate = estimate or Estimate()
    lost, change = how.get("lost", lambda t: False), how.get("change", lambda p, r: (p, r))
    believed_s = how.get("announced_s", latency_s)
    ticks = np.arange(0, round(duration_s * 1e6), TICK_US)
    captured = np.arange(int(duration_s * rate_hz)) / rate_hz
    if "jitter" in how:
        captured = captured + how["jitter"] / rate_hz * rng.uniform(-0.5, 0.5, len(captured))
        captured = captured - captured[0]
    predictions, i = [], 0
    for now_us in ticks:
        while i < len(captured) and captured[i] + latency_s <= now_us * 1e-6:
            position, rotation = truth(captured[i])
            if noise_m:
                position = position + noise_m * rng.standard_normal(3)
                noise = 7 * noise_m * rng.standard_normal(3)  # 0.02 degrees if noise_m is 0.05 mm
                rotation = oracle.quaternion_multiply(turn(noise, np.linalg.norm(noise)), rotation)
            if not lost(captured[i]):
                estimate.sample(
                    *change(position, rotation), round((captured[i] + latency_s - believed_s) * 1e6), int(now_us)
                )
            i += 1
        predictions.append(estimate.predict(int(now_us), ahead_s))
    return ticks * 1e-6, np.array(predictions)


def angle_between(a, b):
    return (
        2 * np.arcsin(np.clip(np.minimum(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1)) / 2, 0, 1)) * 2
    )


# ---- motions known in closed form


@pytest.mark.parametrize("rate_hz", RATES_HZ)
@pytest.mark.parametrize("latency_s", [0.004, 0.06])
def test_a_steady_motion_is_predicted_without_error(rate_hz, latency_s):
    """Once settled, the prediction equals the hand's position, speed and rotation at the requested time."""
    velocity, spin = np.array([0.3, -0.4, 0.2]), 2.0
    axis = np.array([1.0, 2.0, -2.0]) / 3

    def truth(t):
        return velocity * t, turn(axis, spin * t)

    for ahead_s in (-0.001, 0.0, 0.0035):
        t, got = run(truth, 2.5, rate_hz, latency_s, ahead_s=ahead_s)
        late = t > 2
        place = np.outer(t[late] + ahead_s, velocity)
        assert np.abs(got[late, 4:7] - place).max() < 2e-4
        assert np.abs(got[late, 7:10] - velocity).max() < 2e-3
        assert angle_between(got[late, :4], turn(axis, spin * (t[late] + ahead_s))).max() < 1e-3
        assert np.abs(got[late, 10:] - spin * axis).max() < 1e-2


def test_a_hand_that_accelerates_is_followed():
    """The estimate follows an accelerating hand without the lag of a filter that assumes a constant velocity. The
    remaining error is of the order of (filter memory)^3 x acceleration / (time in which the acceleration fades)."""
    acceleration = 2.0
    t, got = run(lambda t: (0.5 * acceleration * t**2 * X, IDENTITY), 1.0)
    late = t > 0.6
    assert np.abs(got[late, 4] - 0.5 * acceleration * t[late] ** 2).max() < 1e-3
    assert np.abs(got[late, 7] - acceleration * t[late]).max() < 0.05


@pytest.mark.parametrize("rate_hz", [60, 120, 250])
def test_irregular_and_lost_samples_are_tolerated(rate_hz, rng):
    velocity = np.array([0.3, -0.4, 0.2])
    t, got = run(
        lambda t: (velocity * t, IDENTITY),
        4.0,
        rate_hz,
        rng=rng,
        jitter=0.4,
        lost=lambda t: round(t * rate_hz) % 10 == 3,
    )
    late = t > 3
    assert np.abs(got[late, 4:7] - np.outer(t[late], velocity)).max() < 2e-4


@pytest.mark.parametrize("wrong_s", [-0.01, 0.01])
def test_a_wrong_latency_only_shifts_the_time(wrong_s):
    t, got = run(lambda t: (0.4 * t * X, IDENTITY), 3.0, latency_s=0.02, announced_s=0.02 + wrong_s)
    late = t > 2
    assert np.abs(got[late, 4] - 0.4 * (t[late] + wrong_s)).max() < 2e-4
    assert np.abs(got[late, 7] - 0.4).max() < 2e-3


def test_the_velocity_is_the_derivative_of_the_pose():
    """Between samples, once the last correction has faded, the predicted velocity agrees with finite differences
    between predictions made in the same tick for slightly earlier and later times."""
    estimate = Estimate()

    def truth(t):
        return 0.1 * np.sin([3 * t, 4 * t, 5 * t]), turn([1, 1, 1], np.sin(3 * t))

    run(truth, 1.0, 30, 0.03, estimate=estimate)
    now_us = 1_030_000
    step_s = 0.004
    before, here, after = (estimate.predict(now_us, ahead) for ahead in (-step_s, 0.0, step_s))
    assert (after[4:7] - before[4:7]) / (2 * step_s) == pytest.approx(here[7:10], abs=1e-4)
    rate = oracle.quaternion_multiply((after[:4] - before[:4]) / step_s, oracle.quaternion_conjugate(here[:4]))[1:]
    assert rate == pytest.approx(here[10:], abs=1e-2)


@pytest.mark.parametrize(("latency_s", "most"), [(0.0, 1.2), (0.02, 1.4), (0.05, 2.4)])
def test_a_shaking_hand_is_not_amplified_beyond_the_cost_of_its_latency(latency_s, most):
    """A shake of the hand at 4 Hz and 50 mm is amplified by a factor of at most 1.2 without latency, and of at most 2.4
    at a latency of 50 ms. An earlier estimate, which extrapolated a constant acceleration over the whole horizon,
    amplified the shake by factors of 1.1 to 3.1 and mistook it for noise."""
    estimate = Estimate()
    t, got = run(lambda t: (0.05 * np.sin(8 * np.pi * t) * X, IDENTITY), 4.0, 250, latency_s, estimate=estimate)
    assert np.abs(got[t > 2, 4]).max() < most * 0.05


# ---- the filter's equations in double precision


class Reference:
    """Morrison's third-order fading-memory filter in double precision, for translation only, with exact exponentials
    and the firmware's rule for the length of the memory."""

    def __init__(self):
        self.p = self.v = self.a = self.innovation = self.change = self.trend = np.zeros(3)
        self.variance, self.time, self.memory = (5e-5) ** 2, 0.03, 0.038
        self.t = None

    def sample(self, z, t):
        if self.t is None:
            self.p, self.t = z, t
            return
        dt, self.t = t - self.t, t
        p, v = self.p + self.v * dt + self.a * dt**2 / 2, self.v + self.a * dt
        rho = z - p
        theta = np.exp(-dt / self.memory)
        change = rho - self.innovation
        measured, self.change = theta**3 * np.sum((change - self.change) ** 2) / 18, change
        self.time = min(self.time + dt, 1.0)
        self.variance += (min(measured, 9 * self.variance) - self.variance) * dt / self.time
        self.variance = np.clip(self.variance, 1e-5**2, 5e-3**2)
        self.innovation = rho
        self.trend = theta * self.trend + (1 - theta) * rho
        excess = np.sum(self.trend**2) / (3 * self.variance / theta**3 * (1 - theta) / (1 + theta))
        shortest = 0.038 * (self.variance * dt / (5e-5**2 * 0.004) / max(excess / 10, 1)) ** (1 / 8)
        self.memory = min(self.memory + (2.8 * shortest - self.memory) * dt, 2.8 * shortest / max(excess, 1e-9))
        self.memory = max(self.memory, shortest)
        theta = np.exp(-dt / self.memory)
        self.p = p + (1 - theta**3) * rho
        self.v = v + 1.5 * (1 - theta**2) * (1 - theta) * rho / dt
        self.a = self.a * np.exp(-dt / 0.15) + (1 - theta) ** 3 * rho / dt**2


@pytest.mark.parametrize("noise_m", [5e-5, 5e-4])
@pytest.mark.parametrize("rate_hz", [60, 250])
def test_the_filter_matches_its_equations(rate_hz, noise_m, rng):
    """The errors due to float32 and the rational exponential are small compared with the noise, for a hand that rests,
    reaches and rests again, with noise and irregular intervals."""
    estimate, reference = Estimate(), Reference()
    t = 0.0
    difference, memories = [], []
    for _ in range(4 * rate_hz):
        t += round(1e6 / rate_hz * rng.uniform(0.8, 1.2)) * 1e-6
        position = (
            0.2 * minimum_jerk((t - 2) / 0.6) * np.array([1, -0.5, 2]) + noise_m * rng.standard_normal(3)
        ).astype(np.float32)
        now_us = round(t * 1e6)
        estimate.sample(position, IDENTITY, now_us, now_us)
        reference.sample(position.astype(float), t)
        state = estimate.state
        got = [state.pose.translation_m.x, state.pose.translation_m.y, state.pose.translation_m.z]
        difference.append(np.abs(got - reference.p).max())
        memories.append((state.translation.memory_s, reference.memory))
    assert max(difference) < 0.2 * noise_m
    memories = np.array(memories)
    assert np.abs(memories[:, 0] / memories[:, 1] - 1).max() < 0.1
    assert memories[:, 1].max() > 3 * memories[:, 1].min()  # the memory has adapted


# ---- invariants


def wander(t):
    return 0.1 * np.sin([3 * t, 4 * t + 1, 5 * t]), turn([1, 2, 3], np.sin(2 * t))


def test_the_trackers_position_does_not_matter():
    """The same motion, seen in a different frame, is predicted identically in that frame."""
    placed, shift = turn([3, -1, 2], 2.1), np.array([0.7, -1.1, 0.4])
    _, here = run(wander, 1.5, 120, 0.01)
    seen = lambda p, r: (oracle.rotate(placed, p) + shift, oracle.quaternion_multiply(placed, r))  # noqa: E731
    _, there = run(wander, 1.5, 120, 0.01, change=seen)
    here, there = here[20:], there[20:]
    assert np.abs(there[:, 4:7] - oracle.rotate(placed, here[:, 4:7]) - shift).max() < 2e-6
    assert (
        angle_between(
            there[:, :4], oracle.quaternion_multiply(np.broadcast_to(placed, (len(here), 4)), here[:, :4])
        ).max()
        < 3e-5
    )
    assert np.abs(there[:, 7:10] - oracle.rotate(placed, here[:, 7:10])).max() < 1e-3
    assert np.abs(there[:, 10:] - oracle.rotate(placed, here[:, 10:])).max() < 1e-3


def test_flipped_signs_change_nothing(rng):
    _, steady = run(wander, 1.0)
    _, flipped = run(wander, 1.0, change=lambda p, r: (p, r if rng.random() < 0.5 or p @ p < 0.02 else -r))
    assert np.array_equal(steady, flipped)


@pytest.mark.parametrize("zero_us", [WRAP - 500_000, WRAP - 3000, 2**31 - 500_000])
def test_the_clock_may_wrap(zero_us):
    _, here = run(wander, 1.0)
    _, there = run(wander, 1.0, estimate=Estimate(zero_us))
    assert np.array_equal(here, there)


@pytest.mark.parametrize("rate_hz", [30, 90, 250])
def test_a_new_sample_makes_no_jump(rate_hz, rng):
    """With noise, the predicted hand moves from tick to tick hardly further than its speed allows, because the
    correction by a new sample is spread over an interval. The sign of the predicted quaternion does not flip."""
    t, got = run(wander, 3.0, rate_hz, 0.03, noise_m=2e-4, rng=rng)
    late = got[t > 0.5]
    fastest = np.linalg.norm(late[:, 7:10], axis=1).max()
    steps = np.linalg.norm(np.diff(late[:, 4:7], axis=0), axis=1)
    jumps = steps - 1e-3 * fastest
    change_m = 10e-3 if rate_hz == 30 else 2e-3  # the change due to one sample, spread over its interval
    assert jumps.max() < change_m * rate_hz * 1e-3
    assert angle_between(late[1:, :4], late[:-1, :4]).max() < 1e-3 * 2 * np.linalg.norm(late[:, 10:], axis=1).max()
    assert np.sum(late[1:, :4] * late[:-1, :4], axis=1).min() > 0.99  # the sign is continuous


# ---- noise


@pytest.mark.parametrize(
    ("rate_hz", "latency_s", "noise_m"), [(250, 0.004, 5e-5), (120, 0.01, 1e-4), (90, 0.03, 5e-4), (30, 0.06, 1e-3)]
)
def test_noise_at_rest_is_below_one_samples_noise(rate_hz, latency_s, noise_m, rng):
    """A start, clutch or latch takes its reference pose from the estimate. The estimate must be less noisy than a
    sample, because the noise of the reference remains as a constant error until the next one is taken."""
    t, got = run(still, 15.0, rate_hz, latency_s, noise_m, rng)
    late = got[t > 4]
    assert np.sqrt(np.mean(late[:, 4:7] ** 2)) < 0.8 * noise_m
    assert np.sqrt(np.mean(np.linalg.norm(late[:, 1:4], axis=1) ** 2 * 4 / 3)) < 0.8 * 7 * noise_m


@pytest.mark.parametrize("noise_m", [2e-5, 5e-5, 2e-4, 1e-3])
@pytest.mark.parametrize("motion", [still, lambda t: (0.05 * np.sin(4 * t) * X, IDENTITY)], ids=["still", "moving"])
def test_the_noise_is_measured(motion, noise_m, rng):
    estimate = Estimate()
    run(motion, 6.0, noise_m=noise_m, rng=rng, estimate=estimate)
    assert np.sqrt(estimate.state.translation.noise_variance) == pytest.approx(noise_m, rel=0.25)


def test_an_outlier_is_not_counted_as_noise(rng):
    estimate = Estimate()
    run(still, 4.0, noise_m=5e-5, rng=rng, estimate=estimate)
    before = estimate.state.translation.noise_variance
    for i, x_m in enumerate([0.05, 0, 0]):
        estimate.sample(x_m * X, IDENTITY, 4_000_000 + 4000 * i, 4_004_000 + 4000 * i)
    assert estimate.state.translation.noise_variance < 1.15 * before


def test_the_memory_is_long_at_rest_and_short_in_motion(rng):
    estimate, memory = Estimate(), []

    def truth(t):
        memory.append((t, estimate.state.translation.memory_s))
        return 0.15 * minimum_jerk((t - 4) / 0.8) * X, IDENTITY

    run(truth, 8.0, noise_m=5e-5, rng=rng, estimate=estimate)
    t, memory = np.array(memory).T
    assert memory[(t > 3) & (t < 4)].min() > 2 * lib.MOTION_FILTER_MEMORY_S
    assert memory[(t > 4.15) & (t < 4.65)].max() < 1.5 * lib.MOTION_FILTER_MEMORY_S
    assert memory[t > 7.5].min() > 2 * lib.MOTION_FILTER_MEMORY_S


# ---- gaps


@pytest.mark.parametrize("rate_hz", [30, 120, 500])
def test_in_a_gap_the_prediction_comes_to_rest(rate_hz):
    """The prediction continues for 2.5 times the usual interval plus 5 ms, then slows down, and is at rest after GAP_S.
    The predicted speed is continuous and never exceeds the speed before the gap."""
    t, got = run(lambda t: (0.4 * t * X, turn([0, 0, 1], t)), 3.0, rate_hz, lost=lambda t: t > 2)
    speed, step = got[:, 7], np.diff(got[:, 4])
    last_s = np.floor(2 * rate_hz) / rate_hz + 0.004
    gap_s = last_s + lib.HAND_MOTION_AWAITED_INTERVALS / rate_hz + lib.HAND_MOTION_GRACE_S
    assert speed[(t > last_s) & (t < gap_s - 0.001)] == pytest.approx(0.4, abs=2e-3)
    during = (t > gap_s - 0.002) & (t < gap_s + GAP_S + 0.004)
    assert np.abs(np.diff(speed[during])).max() < 1.2 * 0.4 * 1e-3 / GAP_S
    assert step[t[:-1] > 1.5].max() < 0.42e-3
    assert step[t[:-1] > 1.5].min() >= 0
    rest = t > gap_s + GAP_S + 0.002
    assert np.array_equal(got[rest][0], got[-1])
    assert not got[rest][:, 7:].any()
    assert got[-1, 4] == pytest.approx(0.4 * (gap_s + GAP_S / 2), abs=1e-3)


@pytest.mark.parametrize("gap_s", [0.08, 0.3, 2.0])
@pytest.mark.parametrize("rate_hz", [60, 250])
def test_after_a_gap_it_restarts_without_a_spike(rate_hz, gap_s):
    """After a gap in which the hand has continued to move, the estimated speed exceeds the hand's speed by less than
    half, and the estimate soon follows the hand again."""
    speed = 0.3
    t, got = run(
        lambda t: (0.1 * np.sin(speed / 0.1 * t) * X, IDENTITY), 4.0, rate_hz, lost=lambda t: 1.5 < t < 1.5 + gap_s
    )
    assert np.abs(got[t > 0.5, 7]).max() < 1.5 * speed
    met = t > 1.5 + gap_s + 0.35
    assert np.abs(got[met, 4] - 0.1 * np.sin(speed / 0.1 * t[met])).max() < 3e-3


def test_after_a_gap_the_earlier_speed_is_discarded():
    """A hand that stopped at the start of the gap is predicted to be at rest after the gap. If the samples before and
    after the gap were treated as one motion, the old speed would make the prediction move backwards."""
    t, got = run(lambda t: (0.4 * min(t, 1.0) * X, IDENTITY), 1.6, lost=lambda t: 1.0 < t < 1.3)
    assert np.abs(got[t > 1.31, 7]).max() < 0.01


def test_a_reset_leaves_the_hand_at_rest_where_it_was_last_seen():
    estimate = Estimate()
    run(lambda t: (0.3 * t * X, IDENTITY), 1.0, estimate=estimate)
    lib.hand_motion_reset(estimate.state)
    at_rest = estimate.predict(1_000_000)
    assert at_rest[4] == pytest.approx(0.3, abs=5e-3)
    assert not at_rest[7:].any()
    estimate.sample(X, IDENTITY, 77, 1_500_000)  # the tracker's clock has restarted
    assert not estimate.predict(1_900_000)[7:].any()
    assert estimate.predict(1_900_000)[4] == 1.0


def test_a_tracker_that_slows_down_is_not_taken_for_gaps():
    """When the tracker slows down from 250 to 15 Hz, prediction resumes after a few samples."""
    estimate = Estimate()
    run(lambda t: (0.3 * t * X, IDENTITY), 1.0, 250, estimate=estimate)
    for i in range(1, 60):
        now_us = 1_000_000 + 66_667 * i
        estimate.sample(0.3e-6 * now_us * X, IDENTITY, now_us, now_us)
    assert estimate.predict(now_us + 60_000)[4] == pytest.approx(0.3e-6 * (now_us + 60_000), abs=1e-3)


# ---- bounds


def test_without_a_sample_the_pose_is_the_identity_at_rest():
    assert list(Estimate().predict(12345)) == [1, 0, 0, 0] + 9 * [0]


def test_an_old_sample_is_extrapolated_by_a_tenth_of_a_second_at_most():
    """With an announced latency of 0.5 s, the hand is predicted as if the latency were 0.1 s."""
    t, got = run(lambda t: (0.4 * t * X, IDENTITY), 3.0, latency_s=0.5)
    assert got[-1, 4] == pytest.approx(0.4 * (t[-1] - 0.5 + lib.HAND_MOTION_LATENCY_MAX_S), abs=2e-3)


def test_the_estimated_speed_is_capped():
    estimate = Estimate()
    _, got = run(lambda t: (30 * t * X, turn([0, 0, 1], 80 * t)), 0.5, estimate=estimate)
    state = estimate.state
    assert state.translation.velocity.x == pytest.approx(20, rel=1e-5)
    assert state.rotation.velocity.z == pytest.approx(50, rel=1e-5)
    assert np.isfinite(got).all()


def test_the_estimate_is_finite_and_bounded_for_any_input(rng):
    """The estimate stays finite and bounded for random poses, near and far, at random times, even if the tracker's
    clock jumps back, repeats a time or skips seconds."""
    for far_m in (0.3, 1e3, 1e30):
        estimate, now_us, captured_us = Estimate(), 0, 0
        for _ in range(3000):
            now_us += int(rng.integers(0, 20_000))
            captured_us = int(
                rng.choice(
                    [captured_us, captured_us + 1, now_us, now_us - rng.integers(0, 10**6), rng.integers(0, WRAP)]
                )
            )
            rotation = rng.standard_normal(4)
            estimate.sample(rng.uniform(-far_m, far_m, 3), rotation / np.linalg.norm(rotation), captured_us, now_us)
            got = estimate.predict(now_us + int(rng.integers(0, 100_000)), float(rng.uniform(-0.01, 0.05)))
            assert np.isfinite(got).all()
            assert np.linalg.norm(got[:4]) == pytest.approx(1, abs=1e-5)
            assert np.linalg.norm(got[7:10]) < 20 + 200 * 0.4 + 100
            assert np.linalg.norm(got[10:]) < 50 + 1000 * 0.4 + 500
            assert np.linalg.norm([getattr(estimate.state.translation.velocity, c) for c in "xyz"]) < 20.001
            assert np.linalg.norm([getattr(estimate.state.rotation.velocity, c) for c in "xyz"]) < 50.001


# ---- purpose


@pytest.mark.parametrize(
    ("rate_hz", "latency_s", "noise_m", "part"),
    [(250, 0.004, 5e-5, 0.2), (120, 0.01, 1e-4, 0.2), (90, 0.03, 5e-4, 0.4)],
)
def test_a_reach_is_predicted_far_better_than_by_interpolation(rate_hz, latency_s, noise_m, part, rng):
    """The hand reaches 0.2 m in 1 s with minimum jerk, and later returns. The RMS error of the predicted position is a
    small fraction of the error of hand_tracker's interpolation."""

    def place(t):
        return 0.2 * (minimum_jerk((t - 2) / 1.0) - minimum_jerk((t - 4) / 1.0))

    t, got = run(lambda t: (place(t) * X, IDENTITY), 6.0, rate_hz, latency_s, noise_m, rng)
    interpolated = place(
        t - latency_s - 1.5 / rate_hz
    )  # on average the newest sample is half an interval old, and interpolation reaches it one interval later
    late = t > 1
    predicted = np.sqrt(np.mean((got[late, 4] - place(t[late])) ** 2))
    assert predicted < part * np.sqrt(np.mean((interpolated[late] - place(t[late])) ** 2))
