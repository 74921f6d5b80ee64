"""Compares the whole loop, including encoder, bus and drives, with the ideal loop (ideal_loop.py), and checks that the
whole loop is stable."""

from __future__ import annotations

from pathlib import Path

import bus_log
import ideal_loop
import numpy as np
import oracle
import pytest
import simulation

RECORDINGS = simulation.REPOSITORY.parent / "shared" / "data" / "hand_motion"
VEC8 = ("w", "x", "y", "z", "dual_w", "dual_x", "dual_y", "dual_z")
ENCODER_COUNT_RAD = np.radians(1 / 209)
JOINTS = 4
LAW_4 = ("--param", "prediction=0")
RECORDING_START_S = 2.0  # docs/scenarios.md, teleop


def all_gains(gain_per_s: float) -> list[str]:
    return [word for name in VEC8 for word in ("--param", f"gain_{name}_per_s={gain_per_s}")]


def targets_of(frames: dict) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns, for each tick, the time [us], the target (N, 8) and whether a target exists."""
    trace = frames["TickTrace"]
    valid = trace.raw("target_valid") > 0
    rotation = np.stack([trace[f"target_q{axis}"] for axis in "wxyz"], axis=1)
    rotation[valid] /= np.linalg.norm(rotation[valid], axis=1, keepdims=True)
    position = np.stack([trace[f"target_{axis}_m"] for axis in "xyz"], axis=1)
    return trace.raw("now_us"), oracle.pose(rotation, position), valid


def measured_hands(trace_csv: Path) -> tuple[np.ndarray, np.ndarray]:
    """Returns, for each tick, the time [us] and ODE's end effector pose (N, 8)."""
    table = np.genfromtxt(trace_csv, delimiter=",", names=True, dtype=None, encoding="ascii")
    position = np.stack([table[f"hand_{axis}_m"] for axis in "xyz"], axis=1)
    rotation = np.stack([table[f"hand_q{axis}"] for axis in "wxyz"], axis=1)
    return np.round(table["t_s"] * 1e6).astype(int), oracle.pose(rotation, position)


@pytest.mark.parametrize(
    ("recording", "scale"),  # the scale keeps the target within the arm's reach
    [("kth_ho_p1s1h2_giver_raw", 0.1), ("kth_ho_sample_taker", 0.1), ("cmu_13_08_rhand", 0.2), ("kul_pour1_com", 0.1)],
)
def test_the_simulated_arm_follows_the_ideal_loop(tmp_path, recording, scale):
    path = RECORDINGS / f"{recording}.csv"
    if not path.exists():
        pytest.skip(f"needs the recorded hand {path}, which is not part of this checkout")
    run = simulation.run(
        tmp_path / "out", "--scenario", "teleop", "--tracker", path, "--scale", scale, *LAW_4
    ).require_pass()
    assert run.summary["reach"]["out_of_reach_s"] == 0
    frames = bus_log.read(run.log)
    now_us, targets, cooperating = targets_of(frames)
    start = np.array([frames[f"JointState{i}"]["position_rad"][0] for i in range(JOINTS)])

    ideal = ideal_loop.run(targets, cooperating, start)

    t_us, hands = measured_hands(run.trace)
    _, tick, row = np.intersect1d(now_us[cooperating], t_us, return_indices=True)
    assert len(tick) > 5000
    ideal, hands = ideal[cooperating][tick], hands[row]
    distance_mm = 1e3 * np.linalg.norm(oracle.translation(ideal) - oracle.translation(hands), axis=1)
    angle_deg = np.degrees(oracle.rotation_angle(ideal, hands))
    assert np.sqrt(np.mean(distance_mm**2)) < 2.0
    assert np.sqrt(np.mean(angle_deg**2)) < 1.0


def minimum_jerk_move(path: Path, displacement_m) -> Path:
    """Writes a tracker recording at 100 Hz with one second of rest, one of motion and two of rest. Playback begins
    RECORDING_START_S after the simulation starts."""
    t = np.arange(0, 4, 0.01)
    s = np.clip(t - 1, 0, 1)
    s = s**3 * (10 - 15 * s + 6 * s**2)
    rows = [f"{a:.2f},{x:.9f},{y:.9f},{z:.9f},1,0,0,0" for a, (x, y, z) in zip(t, np.outer(s, displacement_m))]
    path.write_text("t_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + "\n".join(rows) + "\n")
    return path


@pytest.mark.parametrize("displacement_mm", [(30, 0, 0), (-30, 0, 0), (0, 30, 0), (0, -30, 0), (0, 0, 30), (0, 0, -30)])
def test_default_law_settles_a_30_mm_move_within_1_mm(tmp_path, displacement_mm):
    recording = minimum_jerk_move(tmp_path / "move.csv", np.array(displacement_mm) / 1e3)
    run = simulation.run(tmp_path / "out", "--scenario", "teleop", "--tracker", recording).require_pass()
    assert run.summary["reach"]["out_of_reach_s"] == 0  # the arm can reach the target throughout
    now_us, targets, cooperating = targets_of(bus_log.read(run.log))
    t_us, hands = measured_hands(run.trace)
    settled, tick, row = np.intersect1d(now_us[cooperating], t_us, return_indices=True)
    last_half_second = settled > settled[-1] - 500_000
    error_m = oracle.translation(targets[cooperating][tick]) - oracle.translation(hands[row])
    assert np.linalg.norm(error_m[last_half_second], axis=1).max() < 1e-3
    moved_m = oracle.translation(targets[cooperating])[-1] - oracle.translation(targets[cooperating])[0]
    assert moved_m == pytest.approx(np.array(displacement_mm) / 1e3, abs=2e-4)  # tolerance for marker noise


@pytest.mark.parametrize("gain_per_s", [35, 70, 100])  # default: 35
def test_gain_margin(tmp_path, gain_per_s):
    """With the delays of bus, encoder and drives, the loop does not oscillate at up to nearly three times the default
    gain. Only the encoder's resolution causes motion at rest: an error of one count causes a velocity of one count
    times the gain. The firmware refuses gains far above 100, as too high for the loop's delays."""
    recording = minimum_jerk_move(tmp_path / "move.csv", [0.03, 0, 0])
    run = simulation.run(
        tmp_path / "out",
        "--scenario",
        "teleop",
        "--tracker",
        recording,
        "--noise-mm",
        0,
        "--noise-deg",
        0,
        *LAW_4,
        *all_gains(gain_per_s),
    )
    commands = bus_log.read(run.log)["JointCmd"]
    velocity = bus_log.joint_array(commands, "velocity_{}_radps", JOINTS)
    t = commands.t_s - RECORDING_START_S
    moving = (t > 1.2) & (t < 1.8)
    resting = (t > 3.0) & (t < 4.0)
    assert np.abs(velocity[moving]).max() > 0.05
    assert np.sqrt(np.mean(velocity[resting] ** 2, axis=0)).max() < gain_per_s * ENCODER_COUNT_RAD
