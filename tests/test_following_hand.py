"""Checks controller_step() with prediction: how the arm responds to the hand's motion, frame by frame, with ideal
drives."""

from __future__ import annotations

import numpy as np
import oracle
import pytest
from comanip._core import lib
from controller_bench import TICK_US, Bench

SPEED_MPS = 0.08


def started(**changes) -> Bench:
    bench = Bench(position_deg=(60, -40, 0, -80), prediction=True).until_ready()
    for name, value in changes.items():
        assert bench.write(getattr(lib, f"PARAMETER_{name.upper()}"), value) == lib.RESULT_ACCEPTED
    bench.tick(300)  # time for the motion filter to measure the noise and to lengthen its memory
    return bench.start(lib.TASK_TELEOP)


def position(bench: Bench) -> np.ndarray:
    return oracle.translation(bench.robot)


def move(bench: Bench, velocity_mps, ticks: int, ramp: int = 300) -> np.ndarray:
    """Moves the hand for the given number of ticks. The hand accelerates to the velocity within the first `ramp` ticks
    and then keeps it. Returns the robot's position at each tick."""
    places = []
    for k in range(ticks):
        bench.move_hand(np.asarray(velocity_mps) * min(1, (k + 1) / ramp) * TICK_US * 1e-6)
        bench.tick()
        places.append(position(bench))
    return np.array(places)


def minimum_jerk(t_s: np.ndarray) -> np.ndarray:
    s = np.clip(t_s, 0, 1)
    return s**3 * (10 - 15 * s + 6 * s**2)


def test_a_hand_that_moves_steadily_is_followed_without_lag():
    bench = started()
    hand, robot = oracle.translation(bench.hand), position(bench)
    move(bench, [0, SPEED_MPS, 0], 700)
    lag_m = (oracle.translation(bench.hand) - hand) - (position(bench) - robot)
    assert abs(lag_m[1]) < 0.01 * SPEED_MPS  # a lag below 10 ms; without prediction it is about 33 ms
    assert np.abs(bench.velocity_radps).max() > 0.1


def test_one_parameter_switches_prediction_off():
    bench = started(prediction=0.0)
    hand, robot = oracle.translation(bench.hand), position(bench)
    move(bench, [0, SPEED_MPS, 0], 700)
    lag_s = ((oracle.translation(bench.hand) - hand) - (position(bench) - robot))[1] / SPEED_MPS
    assert 0.025 < lag_s < 0.045  # one tracker period (4 ms) of interpolation plus 1 / K (29 ms)


def test_a_clutch_in_motion_keeps_the_hands_speed():
    """After the clutch, the target starts at the robot's pose and moves with the hand, so the robot keeps its speed.
    An earlier version slowed the robot from 0.156 to 0.043 m/s."""
    bench = started()
    before = move(bench, [0, SPEED_MPS, 0], 600)
    assert bench.command(lib.COMMAND_CLUTCH) == lib.RESULT_ACCEPTED
    after = move(bench, [0, SPEED_MPS, 0], 200, ramp=1)
    speeds = np.diff(after[:, 1]) / (TICK_US * 1e-6)
    assert np.diff(before[-50:, 1]).mean() / (TICK_US * 1e-6) == pytest.approx(SPEED_MPS, rel=0.1)
    assert speeds.min() > 0.8 * SPEED_MPS and speeds.max() < 1.2 * SPEED_MPS


def test_a_gap_in_motion_ends_in_a_smooth_stop():
    bench = started(stale_periods=25)
    move(bench, [0, SPEED_MPS, 0], 600)
    bench.hand = None
    start = position(bench)
    bench.tick(80)  # the predicted motion has ended, but the hand becomes stale only after 100 ms
    assert bench.mode == lib.MODE_COOPERATING
    assert np.abs(bench.velocity_radps).max() < 0.15
    bench.tick(60)
    assert bench.mode == lib.MODE_HOLD and (bench.velocity_radps == 0).all()
    assert (position(bench) - start)[1] < SPEED_MPS * 0.08


@pytest.mark.parametrize("ticks_lost", [100, 1500])
def test_after_a_loss_the_start_does_not_use_the_old_hand_position(ticks_lost):
    """The tracker loses the hand, and the hand moves by 200 mm and stops. The arm does not move, even if the
    cooperation is started as soon as the firmware accepts a start."""
    bench = Bench(position_deg=(60, -40, 0, -80), prediction=True).until_ready()
    assert bench.write(lib.PARAMETER_TASK_BLEND_S, 0.0) == lib.RESULT_ACCEPTED
    hand, bench.hand = bench.hand, None
    bench.tick(ticks_lost)
    bench.hand = hand
    bench.move_hand([0.2, 0, 0])
    while bench.mode != lib.MODE_READY:
        bench.tick()
    robot = position(bench)
    assert bench.command(lib.COMMAND_START) == lib.RESULT_ACCEPTED
    bench.tick(500)
    assert np.linalg.norm(position(bench) - robot) < 1e-3


def test_prediction_starts_with_the_current_hand_pose():
    bench = Bench(position_deg=(60, -40, 0, -80), prediction=True).until_ready()
    assert bench.write(lib.PARAMETER_PREDICTION, 0.0) == lib.RESULT_ACCEPTED
    bench.move_hand([0.2, 0, 0])
    bench.tick(50)
    assert bench.write(lib.PARAMETER_PREDICTION, 1.0) == lib.RESULT_ACCEPTED
    robot = position(bench)
    assert bench.command(lib.COMMAND_START) == lib.RESULT_ACCEPTED
    bench.tick(500)
    assert np.linalg.norm(position(bench) - robot) < 1e-3


def test_the_reference_is_the_estimate_and_not_one_sample(rng):
    """After a start from noisy samples, the robot moves less (RMS over several starts) than it would if the reference
    pose were the last sample."""
    sigma_m, offsets = 1e-3, []
    for _ in range(12):
        bench = Bench(position_deg=(60, -40, 0, -80), prediction=True).until_ready()
        still = oracle.translation(bench.hand)
        for _ in range(500):
            bench.hand = oracle.pose(bench.hand[:4], still + rng.normal(0, sigma_m, 3))
            bench.tick()
        bench.start(lib.TASK_TELEOP)
        robot = position(bench)
        bench.hand = oracle.pose(bench.hand[:4], still)
        bench.tick(1500)
        offsets.append(np.linalg.norm(position(bench) - robot))
    assert np.sqrt(np.mean(np.square(offsets))) < 1.0 * sigma_m  # with a single sample it would be sqrt(3) sigma


def test_a_target_that_returns_into_reach_causes_no_overshoot():
    bench = started()
    robot = position(bench)
    t = np.arange(0, 5.0, TICK_US * 1e-6)
    way = 0.25 * (minimum_jerk(t) - minimum_jerk(t - 2.0))  # at most 0.47 m/s
    fastest, beyond, met = 0.0, 0.0, False
    for k in range(len(t)):
        bench.move_hand([0, 0, way[k] - (way[k - 1] if k > 0 else 0)])
        bench.tick()
        if t[k] > 2.0:
            fastest = max(fastest, np.abs(bench.velocity_radps).max())
            above_m = robot[2] + way[k] - position(bench)[2]
            met = met or abs(above_m) < 1e-3
            beyond = max(beyond, above_m if met else 0.0)
        elif t[k] > 1.0:
            assert robot[2] + way[k] - position(bench)[2] > 0.02  # the target is out of reach
    assert np.linalg.norm(position(bench) - robot) < 1e-3
    assert fastest < 0.6 * 4.76
    assert beyond < 5e-3
    assert (bench.velocity_radps == 0).all()
