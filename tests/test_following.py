"""Checks how `make following` measures control laws: its results for paths with known delay and noise, its reference
target against the paper's Algorithm 1, and its kinematic loop against closed-form results."""

from __future__ import annotations

import dataclasses

import hoap3
import numpy as np
import oracle
import pytest
from comanip_dev.following import followers, metrics, one, plan, rotations
from comanip_dev.following.arm_model import ArmModel
from comanip_dev.following.case import Scene, follow, noise_at_rest_um
from comanip_dev.following.loop import LoopError, run_firmware
from comanip_dev.following.recorded_hand import HEADER, HandMotion, Recording, RecordingError, read
from comanip_dev.following.scale import largest_scale
from comanip_dev.following.target import targets
from comanip_dev.following.tracker import MOUNT_M, MOUNT_ROTATION, Tracker, measure

ARM = ArmModel("hoap3_right")
TRACKER = Tracker(rate_hz=250.0, latency_s=0.004, noise_m=0.05e-3)
START_RAD = np.radians([60.0, -30.0, -10.0, -80.0])


def sway(duration_s: float = 6.0, amplitude_m: float = 0.03, frequency_hz: float = 0.5) -> Recording:
    """Returns a smooth motion, sampled at 100 Hz, that starts and ends at rest."""
    t_s = np.arange(0.0, duration_s, 0.01)
    swing = 1.0 - np.cos(2 * np.pi * frequency_hz * t_s)
    displacement_m = amplitude_m / 2 * swing[:, None] * np.array([1.0, 0.5, -0.3])
    turn = rotations.from_vector(0.2 * swing[:, None] * np.array([0.0, 0.6, 0.8]))
    return Recording("sway", t_s, displacement_m, turn, np.zeros(len(t_s) - 1, bool))


def scene(**changes) -> Scene:
    return dataclasses.replace(Scene(sway(), "teleop", 1.0, 0.3), **changes)


# ---- figures


def wander(t_s: np.ndarray) -> np.ndarray:
    return np.stack([0.05 * np.sin(3.1 * t_s), 0.03 * np.cos(7.3 * t_s), 0.02 * np.sin(1.7 * t_s + 1.0)], axis=1)


@pytest.mark.parametrize("delay_ms", [-7.25, 0.0, 3.5, 41.0, 152.6])
def test_delay_is_found_for_any_offset(rng, delay_ms):
    t_s = np.arange(8000) * 1e-3
    path_m = wander(t_s - 1e-3 * delay_ms) + [0.1, -0.2, 0.05] + rng.normal(scale=1e-4, size=(8000, 3))
    assert metrics.delay_ms(path_m, wander(t_s)) == pytest.approx(delay_ms, abs=0.1)


def test_no_delay_without_motion_or_beyond_the_search_range():
    t_s = np.arange(8000) * 1e-3
    assert np.isnan(metrics.delay_ms(wander(t_s), np.zeros((8000, 3))))
    assert np.isnan(metrics.delay_ms(wander(t_s - 0.25), wander(t_s)))


def test_error_noise_and_acceleration_of_known_paths(rng):
    still = np.tile([0.2, -0.1, 0.3], (200000, 1))
    shaken = still + rng.normal(scale=100e-6, size=still.shape)
    assert metrics.noise_um(shaken) == pytest.approx(100 * np.sqrt(3), rel=0.01)
    assert metrics.rms(metrics.errors_mm(shaken, still)) == pytest.approx(0.1 * np.sqrt(3), rel=0.01)
    t_s = np.arange(10000) * 1e-3
    circle = 0.1 * np.stack([np.cos(5 * t_s), np.sin(5 * t_s), 0 * t_s], axis=1)
    assert metrics.acceleration_rms_mps2(circle) == pytest.approx(0.1 * 5**2, rel=1e-4)


def test_ticks_at_a_limit_are_counted():
    command = np.zeros((101, 2))
    command[50:, 1] = 0.025  # a single step of 25 rad/s^2
    command[60:70, 0] = np.minimum(0.024 * np.arange(1, 11), 4.76)
    command[70:, 0] = 0.24
    assert metrics.limit_share(command, np.array([4.76, 4.76]), 25.0) == pytest.approx(1 / 100)
    assert metrics.limit_share(command, np.array([0.24, 4.76]), 25.0) == pytest.approx(33 / 100)


# ---- the reference target


@pytest.mark.parametrize("task", ["teleop", "mirror", "pour"])
def test_reference_target_matches_algorithm_1(rng, task):
    """The reference target agrees with the paper's Algorithm 1, evaluated with dqrobotics on the hand poses that the
    tracker measures."""
    count = 50
    recording = Recording(
        "random", np.arange(count) * 0.1, np.vstack([np.zeros(3), rng.normal(scale=0.1, size=(count - 1, 3))]),
        np.vstack([[1.0, 0, 0, 0], oracle.random_rotations(rng, count - 1)]), np.zeros(count - 1, bool),
    )  # fmt: skip
    motion = HandMotion(recording, 0.5, 1.0, 0.0, 0.0)
    samples = measure(Tracker(10.0, 0.0, 0.0), motion)
    seen = [oracle.pose(r, t) for r, t in zip(samples.rotation, samples.position_m)]
    start_m, start_rotation = ARM.hand(START_RAD[None])
    reference = oracle.Algorithm1(task, seen[0], oracle.pose(start_rotation[0], start_m[0]), oracle.EQUATION_9)
    expected = np.array([reference.target(hand) for hand in seen])
    target_m, rotation = targets(task, start_m[0], start_rotation[0], *motion.displacement(samples.measured_us * 1e-6))
    np.testing.assert_allclose(target_m, [oracle.translation(row) for row in expected], atol=1e-7)
    found = np.array([oracle.pose(r, t) for r, t in zip(rotation, target_m)])
    assert oracle.pose_distance(found, expected).max() < 1e-7


def test_arm_matches_hoap3_and_its_jacobian_is_the_derivative(rng):
    q = np.array([hoap3.random_posture(rng) for _ in range(20)])
    position_m, jacobian = ARM.position_jacobian(q)
    np.testing.assert_allclose(position_m, [hoap3.frames(row)[-1][:3, 3] for row in q], atol=1e-7)
    for joint in range(4):
        step = 1e-6 * np.eye(4)[joint]
        difference = (ARM.hand(q + step)[0] - ARM.hand(q - step)[0]) / 2e-6
        np.testing.assert_allclose(jacobian[:, :, joint], difference, atol=1e-8)


def test_positions_of_postures_are_reached_and_others_not(rng):
    q = np.array([hoap3.random_posture(rng) for _ in range(100)])
    target_m, _ = ARM.hand(q)
    found, distance_m = ARM.reach(target_m, q + rng.normal(scale=0.1, size=q.shape))
    assert (distance_m < 1e-6).mean() > 0.95
    np.testing.assert_allclose(np.linalg.norm(ARM.hand(found)[0] - target_m, axis=1), distance_m, atol=1e-9)
    assert (found >= ARM.position_min_rad).all() and (found <= ARM.position_max_rad).all()
    _, far_m = ARM.reach(np.array([[1.0, 0.0, 0.0]]), START_RAD[None])
    shoulder_m = np.array([-0.035, -0.111, 0.125])
    assert far_m[0] == pytest.approx(np.linalg.norm([1.0, 0, 0] - shoulder_m) - 0.282, abs=0.01)


def test_scale_is_the_largest_with_everything_in_reach():
    """The hand moves straight up from the start. With the scale that largest_scale() finds, the arm is fully stretched
    at the end of the path, 0.282 m from the shoulder."""
    t_s = np.arange(0.0, 2.0, 0.01)
    up = np.outer(t_s / t_s[-1], [0.0, 0.0, 1.0])
    recording = Recording("up", t_s, up, np.tile([1.0, 0, 0, 0], (len(t_s), 1)), np.zeros(len(t_s) - 1, bool))
    start_m = ARM.hand(START_RAD[None])[0][0] - [-0.035, -0.111, 0.125]
    way_m = -start_m[2] + np.sqrt(0.282**2 - start_m[0] ** 2 - start_m[1] ** 2)
    assert largest_scale(ARM, "teleop", START_RAD, recording, 0.3) == pytest.approx(way_m, rel=0.01)


# ---- the tracker


def test_tracker_sees_the_hand_where_it_was_with_its_noise():
    motion = scene().motion
    tracker = Tracker(120.0, 0.01, 0.5e-3)
    samples, clean = measure(tracker, motion), measure(dataclasses.replace(tracker, noise_m=0.0), motion)
    displacement_m, _ = motion.displacement(samples.measured_us * 1e-6)
    in_torso_m = rotations.rotate(MOUNT_ROTATION, clean.position_m) + MOUNT_M
    np.testing.assert_allclose(in_torso_m - in_torso_m[0], displacement_m, atol=1e-12)
    assert (samples.position_m - clean.position_m).std() == pytest.approx(0.5e-3, rel=0.05)
    turned = rotations.angle_between(samples.rotation, clean.rotation)
    assert np.degrees(metrics.rms(turned)) == pytest.approx(0.2 * np.sqrt(3), rel=0.05)
    assert (samples.received_us - samples.measured_us == 10150).all()
    assert np.abs(np.diff(samples.measured_us) - 1e6 / 120).max() < 1


def test_hand_is_hidden_strictly_inside_a_gap():
    recording = dataclasses.replace(sway(), gap=np.arange(599) == 100)
    motion = HandMotion(recording, 1.0, 1.0, 2.0, 0.5)
    assert motion.visible(np.array([1.0, 3.0, 3.004, 3.0101, 4.0])).tolist() == [True, True, False, True, True]


# ---- the loop


def test_a_run_repeats_with_its_seed_and_differs_with_another():
    first = follow(ARM, scene(), TRACKER, followers.firmware({}))
    assert follow(ARM, scene(), TRACKER, followers.firmware({})) == first
    assert follow(ARM, scene(), dataclasses.replace(TRACKER, seed=2), followers.firmware({})) != first


def test_former_default_lags_by_the_sum_of_its_parts():
    """For a slow sway without noise, the lag is the sum of 4 ms of tracker latency, half a tick until a command is
    read, one tracker period (4 ms) of interpolation, 1/K, and one tick of feedback. The tolerance covers the time for
    which frames wait for the next tick."""
    figures = follow(ARM, scene(), dataclasses.replace(TRACKER, noise_m=0.0), followers.named(plan.FORMER))
    assert figures.delay_ms == pytest.approx(4 + 0.5 + 4 + 1e3 / 35 + 1, abs=1.5)
    speed_mps = np.pi * 0.5 * 0.03 * np.linalg.norm([1.0, 0.5, -0.3]) / np.sqrt(2)
    assert figures.rms_mm == pytest.approx(figures.delay_ms * speed_mps, rel=0.05)
    assert figures.limit_percent == 0.0


def test_longer_latency_adds_the_same_delay():
    still = dataclasses.replace(TRACKER, noise_m=0.0)
    late = dataclasses.replace(still, latency_s=0.034)
    former = followers.named(plan.FORMER)
    difference_ms = follow(ARM, scene(), late, former).delay_ms - follow(ARM, scene(), still, former).delay_ms
    assert difference_ms == pytest.approx(30.0, abs=0.3)


def test_noise_at_rest_grows_with_the_trackers():
    former = followers.named(plan.FORMER)
    small, large = (
        noise_at_rest_um(ARM, "teleop", dataclasses.replace(TRACKER, noise_m=n), former) for n in (5e-5, 1e-4)
    )
    assert large / small == pytest.approx(2.0, rel=0.3)
    assert 1.0 < small < 1e6 * 5e-5 * np.sqrt(3)  # less than the tracker's own noise of 50 um per axis


def test_encoders_quantise_and_joints_integrate_their_commands():
    motion = scene().motion
    run = run_firmware(ARM, "teleop", START_RAD, motion, TRACKER, measure(TRACKER, motion), {})
    servo = np.zeros(4)
    expected = run.position_rad.copy()
    for k in range(len(expected) - 1):
        servo += (run.command_radps[k] - servo) * (1 - np.exp(-1 / 3))
        expected[k + 1] = expected[k] + servo * 1e-3
    np.testing.assert_allclose(run.position_rad, expected, atol=1e-12)
    assert not run.cooperating[:500].any() and run.cooperating[500:].all()


def test_wrong_parameters_are_refused_with_one_line():
    motion = scene().motion
    samples = measure(TRACKER, motion)
    for parameters, text in (({"gain": 1.0}, "parameter 'gain'"), ({"damping": 7.0}, "expected 0 to 1")):
        with pytest.raises(LoopError, match=text):
            run_firmware(ARM, "teleop", START_RAD, motion, TRACKER, samples, parameters)


# ---- files


def write(path, rows) -> None:
    path.write_text("\n".join([HEADER, *(",".join(f"{x:.9f}" for x in row) for row in rows)]) + "\n")


def test_recording_is_read_about_the_torsos_axes(tmp_path):
    """In recordings named cmu_*, the y axis points up, and the z axis corresponds to the torso's x axis."""
    turn = rotations.from_vector(np.array([0.0, 0.3, 0.0]))
    rows = [[5.0, 1, 2, 3, 1, 0, 0, 0], [5.1, 1.0, 2.5, 3.25, *(-turn)]]
    write(tmp_path / "cmu_x.csv", rows)
    recording = read(tmp_path / "cmu_x.csv")
    np.testing.assert_allclose(recording.displacement_m[1], [0.25, 0.0, 0.5])
    np.testing.assert_allclose(rotations.to_vector(recording.turn[1]), [0.0, 0.0, 0.3], atol=1e-8)
    assert recording.duration_s == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,x\n1,2\n", "header"),
        (HEADER + "\n0,0,0,0,1,0,0,0\n", "two or more"),
        (HEADER + "\n0,0,0,0,1,0,0,0\n0,0,0,0,1,0,0,0\n", "increasing t_s"),
        (HEADER + "\n0,0,0,0,1,0,0,0\n1,0,0,x,1,0,0,0\n", "x"),
    ],
)
def test_defective_recordings_are_named(tmp_path, text, message):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(RecordingError, match=f"a.csv.*{message}"):
        read(tmp_path / "a.csv")


def test_one_recording_from_the_command_line(tmp_path, capsys):
    recording = sway()
    write(tmp_path / "sway.csv", np.column_stack([recording.t_s, recording.displacement_m, recording.turn]))
    assert one.main([str(tmp_path / "sway.csv"), "--position-scale", "1", "--set", "damping=0.02"]) == 0
    out = capsys.readouterr().out
    assert "noise at rest" in out and "sway" in out
    assert one.main([str(tmp_path / "nowhere.csv")]) == 2
    assert "nowhere.csv" in capsys.readouterr().err
