"""Checks the campaign of `make following`: how it limits a motion to what the arm can do, its verdict on synthetic
results, known properties of the peers (other methods with which the firmware is compared), the agreement between ODE
and the kinematic loop, and the resumption of an interrupted campaign."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from comanip_dev.experiments.campaign import run_jobs
from comanip_dev.following import __main__ as program
from comanip_dev.following import cases, followers, metrics, ode, one_euro, plan
from comanip_dev.following.arm_model import ArmModel
from comanip_dev.following.case import BEGIN_S, Scene, follow, noise_at_rest_um
from comanip_dev.following.criteria import Judge, tuned
from comanip_dev.following.optimum import optimum, within_limits
from comanip_dev.following.recorded_hand import HEADER, HandMotion, Recording
from comanip_dev.following.results import Results, case_key
from comanip_dev.following.tracker import measure
from hub import wait_until
from simulation import PATIENCE_S

ARM = ArmModel("hoap3_right")
NAMES = ("kth_ho_sample_giver", "kth_ho_sample_taker", "kul_pour1_com", "pyomeca_boxlift_hand")


def sway(frequency_hz: float = 0.5, amplitude_m: float = 0.03) -> Recording:
    t_s = np.arange(0.0, 3.0, 0.01)
    swing = 1.0 - np.cos(2 * np.pi * frequency_hz * t_s)
    still = np.tile([1.0, 0.0, 0.0, 0.0], (len(t_s), 1))
    return Recording(
        "sway", t_s, amplitude_m / 2 * swing[:, None] * [1.0, 0.5, -0.3], still, np.zeros(len(t_s) - 1, bool)
    )


def write(folder, name: str, recording: Recording) -> None:
    rows = np.column_stack([recording.t_s, recording.displacement_m, recording.turn])
    np.savetxt(folder / f"{name}.csv", rows, "%.9f", ",", header=HEADER, comments="")


# ---- motion within the arm's limits


def test_a_path_within_the_limits_is_unchanged():
    t_s = np.arange(400) * 5e-3
    q = 0.3 * np.sin(2 * t_s)[:, None] * np.ones(2)
    bounds = (np.full(2, -1.0), np.full(2, 1.0))
    np.testing.assert_allclose(within_limits(q, 5e-3, bounds, np.full(2, 5.0), 25.0), q, atol=1e-6)


def test_a_step_becomes_the_fastest_allowed_motion():
    """A step in the joint angle becomes a motion from rest to rest that uses the available speed and exceeds none of
    the limits of speed, acceleration and joint angle."""
    step_s, acceleration = 5e-3, 10.0
    q = np.where(np.arange(400) < 200, 0.0, 0.5)[:, None]
    path = within_limits(q, step_s, (np.array([-1.0]), np.array([0.45])), np.array([1.2]), acceleration)
    assert np.abs(np.diff(path, axis=0)).max() <= 1.2 * step_s * 1.001
    assert np.abs(np.diff(path, 2, axis=0)).max() <= acceleration * step_s**2 * 1.001
    assert path.max() <= 0.45 + 5e-4
    assert path[100, 0] == pytest.approx(0.0, abs=5e-3) and path[300, 0] == pytest.approx(0.45, abs=5e-3)
    assert np.abs(np.diff(path, axis=0)).max() > 1.1 * step_s, "the available speed was not used"


def test_slow_hands_are_followable_and_fast_ones_are_not():
    slow, fast = (optimum(ARM, Scene(sway(f), "teleop", 1.0, 0.3)) for f in (0.5, 8.0))
    assert slow.is_followable and slow.rms_mm < 0.01
    assert not fast.is_followable
    assert slow.speed_radps < ARM.velocity_max_radps.min()


# ---- the judge


def results(figure, noise=lambda follower, condition: 20.0) -> Results:
    """Returns results in which figure(loop, follower, condition, setting, recording) yields the figures of each
    case."""
    found = Results(None, "", {})
    for loop in (plan.LOOP, plan.ODE):
        for follower in (*plan.FIRMWARE, *plan.PEER_NAMES):
            for condition in plan.CONDITIONS:
                for setting in plan.SETTINGS:
                    for name in NAMES:
                        for seed in plan.seeds(follower, condition):
                            key = case_key(loop, follower, condition, setting, name, seed)
                            found.values[key] = figure(loop, follower, condition, setting, name)
                    rest = case_key(loop, follower, condition, setting, None, 1)
                    found.values[rest] = {"noise_um": noise(follower, condition)}
    return found


def good(loop, follower, condition, setting, name) -> dict:
    is_ours = follower == plan.DEFAULT
    return {
        "rms_mm": 0.5 if is_ours else 5.0,
        "max_mm": 2.0 if is_ours else 20.0,
        "delay_ms": -2.0 if is_ours else 45.0,
        "acceleration_mps2": 1.0,
        "limit_percent": 1.0,
    }


def judge(figure=good, **options) -> Judge:
    return Judge(results(figure, **options), dict.fromkeys(plan.SETTINGS, NAMES))


def failed(found: Judge) -> set[str]:
    return {c.what for c in [*found.criteria(plan.LOOP), *found.wrong_latency()] if not c.passed}


def test_good_figures_pass_all_criteria():
    assert failed(judge()) == set()


@pytest.mark.parametrize(
    ("figure", "value", "names", "part"),
    [
        ("rms_mm", 3.0, NAMES[:2], "RMS ratio at 250 Hz, 4 ms, 0.05 mm, half 1"),
        ("rms_mm", 3.0, NAMES[2:], "RMS ratio at 90 Hz, 30 ms, 0.5 mm, half 2"),
        ("max_mm", 10.0, NAMES[2:], "largest error's ratio at 120 Hz, 10 ms, 0.1 mm, half 2"),
        ("delay_ms", -20.0, NAMES[:2], "delay at 250 Hz, 4 ms, 0.05 mm, half 1"),
        ("acceleration_mps2", 1.2, NAMES[:2], "acceleration ratio at 250 Hz, 4 ms, 0.05 mm, half 1"),
        ("rms_mm", 3.0, NAMES[2:], "mirror, rotation 0.3: RMS ratio, half 2"),
        ("rms_mm", 3.0, NAMES[:2], "pour, rotation 0.3: RMS ratio, half 1"),
        ("rms_mm", 3.0, NAMES[1:2], "teleop, rotation 1: RMS of kth_ho_sample_taker"),
        ("max_mm", 11.0, NAMES[1:2], "teleop, rotation 1: largest error of kth_ho_sample_taker"),
        ("rms_mm", 3.0, NAMES[:1], "teleop, rotation 1: RMS ratio without those that lock, half 1"),
    ],
)
def test_each_criterion_can_fail(figure, value, names, part):
    def spoilt(loop, follower, condition, setting, name):
        found = good(loop, follower, condition, setting, name)
        return {**found, figure: value} if follower == plan.DEFAULT and name in names else found

    wrong = failed(judge(spoilt))
    assert any(part in what for what in wrong), wrong
    other = part.replace("half 1", "half 0").replace("half 2", "half 1").replace("half 0", "half 2")
    assert other == part or not any(other in what for what in wrong)


def test_noise_may_grow_by_20_um_but_not_at_90_hz():
    def noise(follower, condition):
        return 20.0 + (15.0 if follower == plan.DEFAULT else 0.0)

    assert failed(judge(noise=noise)) == {"noise at rest at 90 Hz, 30 ms, 0.5 mm"}


def test_an_arm_that_oscillates_with_a_wrong_latency_fails():
    wrong = failed(judge(noise=lambda follower, condition: 40.0 if condition.announced_error_ms > 0 else 20.0))
    assert len(wrong) == 2 and all("announced +10 ms" in what for what in wrong)


@pytest.mark.parametrize("lost", ["default", "former"])
def test_a_missing_measurement_does_not_pass(lost):
    found = judge()
    for key in list(found._results.values):
        if key[2] == lost and key[5] in (NAMES[0], "at rest"):
            found._results.values[key] = {"error": "it did not cooperate"}
    judged = found.criteria(plan.LOOP)
    assert all(not c.passed for c in judged if "half 1" in c.what and "RMS ratio" in c.what)
    assert all(math.isnan(c.value) or math.isnan(c.limit) for c in judged if "noise" in c.what)
    assert all(not c.passed for c in judged if "noise" in c.what)
    assert all(
        not c.passed
        for c in Judge(results(good), dict.fromkeys(plan.SETTINGS, ())).criteria(plan.LOOP)
        if "half" in c.what
    )


def test_peers_are_tuned_on_the_other_half():
    """On each half of the recordings, a peer is judged with the setting that is best on the other half. In this test,
    the setting that is best on one half is bad on the other."""
    first, second = plan.folds(NAMES)
    good_for = dict.fromkeys(first, "qp 20") | dict.fromkeys(second, "qp 35")

    def figure(loop, follower, condition, setting, name):
        return {**good(loop, follower, condition, setting, name), "rms_mm": 1.0 if follower == good_for[name] else 9.0}

    assert tuned(judge(figure), "qp", plan.FAST, "rms_mm") == (9.0, ["qp 35", "qp 20"])


def test_each_recording_is_in_one_half():
    first, second = plan.folds([*NAMES, "mine", "yours"])
    assert set(first) | set(second) == {*NAMES, "mine", "yours"} and not set(first) & set(second)
    assert len({"mine", "yours"} & set(first)) == 1


def test_noise_dominated_figures_are_means_over_seeds():
    found = judge()
    for seed, value in ((1, 3.0), (2, 6.0), (3, 9.0)):
        key = case_key(plan.LOOP, plan.DEFAULT, plan.SLOW, plan.TELEOP, NAMES[0], seed)
        found._results.values[key] = {"max_mm": value}
    figure = (plan.LOOP, plan.DEFAULT, plan.SLOW, plan.TELEOP, NAMES[0], "max_mm")
    assert found.figure(*figure) == 6.0
    del found._results.values[key]
    assert math.isnan(found.figure(*figure))


# ---- peers


def test_one_euro_is_a_low_pass_at_rest_and_lets_fast_motion_through():
    """At rest, a first-order low-pass reduces the standard deviation of white noise to the fraction sqrt(s / (2 - s)),
    where s is the weight of the new sample."""
    tracker = plan.Condition(250, 4, 0.5).tracker()
    still = measure(tracker, HandMotion(None, 1.0, 1.0, 0.0, 40.0))
    quiet = one_euro.filtered(still, 1.0, 0.0)
    share = 1.0 / (1.0 + 250.0 / (2 * np.pi))
    left = quiet.position_m[1000:].std(axis=0) / still.position_m[1000:].std(axis=0)
    np.testing.assert_allclose(left, np.sqrt(share / (2 - share)), rtol=0.2)
    motion = Scene(sway(), "teleop", 1.0, 0.3).motion
    moving = measure(plan.Condition(250, 4, 0.0).tracker(), motion)
    slow, fast = (one_euro.filtered(moving, 1.0, beta) for beta in (0.0, 1e4))
    lag_slow, lag_fast = (np.abs(f.position_m - moving.position_m).max() for f in (slow, fast))
    assert lag_slow > 0.005 and lag_fast < 0.1 * lag_slow


@pytest.mark.parametrize("name", ["ruckig 0", "ruckig 0.5", "qp 35"])
def test_peers_follow_within_the_arms_limits(name):
    for package in ("ruckig", "mink"):
        pytest.importorskip(package, reason=f"{package} comes with `make following`")
    scene, tracker = Scene(sway(), "teleop", 1.0, 0.3), plan.Condition(250, 4, 0.0).tracker()
    motion = scene.motion
    run = followers.named(name)(ARM, "teleop", scene.start_rad, motion, tracker, measure(tracker, motion))
    assert np.abs(np.diff(run.command_radps, axis=0)).max() <= 0.025 + 1e-6
    figures = follow(ARM, scene, tracker, followers.named(name))
    assert 10.0 < figures.delay_ms < 60.0 and figures.rms_mm < 4.0
    assert follow(ARM, scene, tracker, followers.named(name)) == figures
    late = plan.Condition(250, 34, 0.0).tracker()
    assert follow(ARM, scene, late, followers.named(name)).delay_ms - figures.delay_ms == pytest.approx(30.0, abs=1.0)


# ---- ODE


@pytest.mark.parametrize("setting", [plan.TELEOP, plan.MIRROR, plan.POUR])
def test_ode_agrees_with_the_kinematic_loop(tmp_path, setting):
    """The figures of ODE's arm and of the kinematic loop's arm agree, although the two share no code except the
    firmware."""
    write(tmp_path, "sway", sway())
    scene = Scene(sway(), setting.task, 0.8, setting.rotation_scale)
    job = ode.job(tmp_path / "run", plan.FORMER, plan.FAST, setting, tmp_path / "sway.csv", 0.8)
    outcome = run_jobs([job])[0]
    found = ode.judge(ARM, setting.task, outcome, BEGIN_S + scene.recording.duration_s)
    expected = follow(ARM, scene, plan.FAST.tracker(), followers.named(plan.FORMER))
    assert found.delay_ms == pytest.approx(expected.delay_ms, abs=0.5)
    assert found.rms_mm == pytest.approx(expected.rms_mm, rel=0.02)
    assert found.max_mm == pytest.approx(expected.max_mm, rel=0.05)
    assert found.rms_deg == pytest.approx(expected.rms_deg, rel=0.02, abs=0.1)
    assert found.acceleration_mps2 == pytest.approx(expected.acceleration_mps2, rel=0.1)


def test_ode_has_the_same_noise_at_rest_as_the_kinematic_loop(tmp_path):
    job = ode.job(tmp_path, plan.FORMER, plan.MIDDLE, plan.TELEOP, None, 1.0)
    expected = noise_at_rest_um(ARM, "teleop", plan.MIDDLE.tracker(), followers.named(plan.FORMER))
    assert ode.noise_um(ARM, run_jobs([job])[0]) == pytest.approx(expected, rel=0.2)


# ---- the program


@pytest.fixture
def few_cases(monkeypatch):
    """Replaces the campaign's hundreds of cases with a few."""

    def few(choice, scenes):
        path, scale = scenes[plan.TELEOP][0]
        return [
            cases.Case(plan.LOOP, plan.FORMER, plan.FAST, plan.TELEOP, path, scale),
            cases.Case(plan.LOOP, plan.FORMER, plan.FAST, plan.TELEOP),
            cases.Case(plan.ODE, plan.FORMER, plan.FAST, plan.TELEOP, path, scale),
        ]

    monkeypatch.setattr(program, "all_cases", few)


def campaign(tmp_path, *arguments: str) -> int:
    return program.main(
        ["--out", str(tmp_path / "out"), "--recordings", str(tmp_path), "--quick", "--jobs", "1", *arguments]
    )


def test_campaign_measures_reports_and_resumes(tmp_path, few_cases, capsys, monkeypatch):
    write(tmp_path, "sway", sway())
    write(tmp_path, "sway_raw", sway())
    assert campaign(tmp_path) == 1, "the campaign must fail if criteria have no measurements"
    out = capsys.readouterr().out
    assert "not measured" in out and "former" in out
    document = json.loads((tmp_path / "out" / "following.json").read_text())
    in_loop, in_ode = (
        next(r for r in document["rows"] if r["loop"] == loop and r["follower"] == plan.FORMER)
        for loop in (plan.LOOP, plan.ODE)
    )
    assert in_loop["condition"] == plan.FAST.label and in_loop["delay_ms"] == pytest.approx(in_ode["delay_ms"], abs=0.5)
    assert not any(c["passed"] for c in document["criteria"])
    assert (tmp_path / "out" / "following.png").stat().st_size > 10000

    kept = (tmp_path / "out" / "results.jsonl").read_text()
    (tmp_path / "out" / "results.jsonl").write_text(kept + '{"version": "cut sho')
    monkeypatch.setattr(
        program, "_in_ode", lambda results, found, *rest: pytest.fail("measured again") if found else None
    )
    monkeypatch.setattr(
        program, "_in_processes", lambda r, work, *rest: pytest.fail("measured again") if list(work) else None
    )
    assert campaign(tmp_path) == 1


def test_an_interruption_is_reported_in_one_line(tmp_path):
    """Ctrl-C in a terminal reaches all processes of the group, including workers that are still starting."""
    write(tmp_path, "sway", sway())
    write(tmp_path, "sway_raw", sway())
    command = [sys.executable, "-m", "comanip_dev.following", "--out", tmp_path / "out", "--recordings", tmp_path]
    process = subprocess.Popen(
        [str(part) for part in (*command, "--jobs", 2)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        start_new_session=True,
    )  # fmt: skip
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    workers_and_tracker = 3
    wait_until(
        lambda: process.poll() is not None or len(children.read_text().split()) == workers_and_tracker, "workers"
    )
    os.killpg(process.pid, signal.SIGINT)
    _, error = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130, error
    assert error.startswith("comanip_dev.following: interrupted: ") and error.count("\n") == 1, error


def test_results_of_another_firmware_are_not_used(tmp_path):
    path = tmp_path / "results.jsonl"
    Results.open(path, "former").add(("a", "b"), {"x": 1})
    assert Results.open(path, "former").values == {("a", "b"): {"x": 1}}
    assert Results.open(path, "new").values == {}


def test_missing_recordings_are_reported(tmp_path, capsys, monkeypatch):
    assert program.main(["--out", str(tmp_path), "--recordings", str(tmp_path / "none")]) == 2
    assert "none: no such folder" in capsys.readouterr().err
    # the default folder does not exist, as in a checkout without recordings
    monkeypatch.setattr(program, "RECORDINGS_FOLDER", tmp_path / "none")
    assert program.main(["--out", str(tmp_path), "--recordings", str(tmp_path / "none")]) == 0
    assert "skipped: there is no folder" in capsys.readouterr().out
    assert campaign(tmp_path) == 2
    assert "no recordings" in capsys.readouterr().err
    (tmp_path / "broken.csv").write_text(HEADER + "\n0,0,0,0,1,0,0,0\n")
    assert campaign(tmp_path) == 2
    assert "broken.csv" in capsys.readouterr().err


def test_a_duplicate_recording_with_gaps_is_left_out(tmp_path):
    write(tmp_path, "a", sway())
    write(tmp_path, "a_raw", sway())
    write(tmp_path, "b_raw", sway())
    (tmp_path / "force.csv").write_text("t_s,Fx_N\n0,1\n")
    paths, left_out = cases.recordings(tmp_path)
    assert [path.stem for path in paths] == ["a", "b_raw"]
    assert left_out == {"a_raw": "the same motion as a", "force": "not a motion of a hand: its header differs"}


def test_limits_match_the_joint_limits_module():
    """For a hand that sways by 0.2 m at 4 Hz, the commands are at a limit in a large share of the ticks. The share
    would be small if the metrics assumed limits other than those of the joint limits module."""
    figures = follow(ARM, Scene(sway(4.0, 0.2), "teleop", 1.0, 0.3), plan.FAST.tracker(), followers.named(plan.FORMER))
    assert figures.limit_percent > 30.0
    assert metrics.TICK_S == 1e-3
