"""Checks that the five experiments pass their physical criteria, and that each criterion can fail."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from comanip_dev.experiments.campaign import Job, Outcome
from comanip_dev.experiments.judgement import Condition
from comanip_dev.experiments.paper_gains import PAPER_GAINS
from simulation import EXIT_CHECK_FAILED, EXPERIMENTS, REPOSITORY, Run, experiment, recording_csv, run, shared

RECORDINGS = REPOSITORY.parent / "shared" / "data" / "hand_motion"


def failed(done: Run) -> set[str]:
    return {check["name"] for check in done.summary["checks"] if not check["pass"]}


def values(done: Run) -> dict[str, float]:
    return {check["name"]: check["value"] for check in done.summary["checks"]}


def variant(tmp_path: Path, name: str, *changes: tuple[str, str]) -> Path:
    """Writes a copy of the experiment's file with some text replaced. Each replaced text must occur exactly once."""
    text = experiment(name).read_text()
    for old, new in changes:
        assert text.count(old) == 1, f"{name}.yaml contains this text {text.count(old)} times: {old}"
        text = text.replace(old, new)
    path = tmp_path / f"{name}_variant.yaml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("name", EXPERIMENTS)
def test_experiment_passes(name, seed):
    done = shared("--scenario", experiment(name), "--seed", seed).require_pass()
    assert done.stderr == ""
    assert done.summary["clearance"]["person_mm"] > 0


@pytest.mark.parametrize("name", ["pour", "teleop"])
def test_a_seed_repeats_an_experiment_bit_for_bit(tmp_path, name):
    first, other = (shared("--scenario", experiment(name), "--seed", seed) for seed in (2, 1))
    second = run(tmp_path / "out", "--scenario", experiment(name), "--seed", 2)
    assert first.log.read_bytes() == second.log.read_bytes()
    assert first.trace.read_bytes() == second.trace.read_bytes()
    assert first.trace.read_bytes() != other.trace.read_bytes()


@pytest.mark.skipif(not RECORDINGS.is_dir(), reason=f"needs recordings: no folder {RECORDINGS}")
@pytest.mark.parametrize("name", ["pour", "teleop", "handover"])
def test_experiment_passes_with_a_recorded_hand(tmp_path, name):
    done = run(tmp_path / "out", "--scenario", experiment(name), "--tracker", RECORDINGS / "kth_ho_sample_giver.csv")
    done.require_pass()
    recording = done.summary["recording"]
    assert recording["file"].endswith("kth_ho_sample_giver.csv") and 0 < recording["position_scale"] < 1


@pytest.mark.skipif(not RECORDINGS.is_dir(), reason=f"needs recordings: no folder {RECORDINGS}")
def test_giver_and_taker_of_one_take_drive_both_people(tmp_path):
    both = (
        "--tracker",
        RECORDINGS / "kth_ho_sample_giver.csv",
        "--tracker-second",
        RECORDINGS / "kth_ho_sample_taker.csv",
    )
    run(tmp_path / "out", "--scenario", experiment("teleop"), *both).require_pass()


@pytest.mark.parametrize("duration", [[], ["--duration", "150"]])
def test_waiting_in_vain_fails_at_any_duration(tmp_path, duration):
    """The run fails if the gripper never closes: the teleoperator waits in vain for robot.holds, and the taker and the
    operator wait for events that would follow from it."""
    path = variant(tmp_path, "teleop", ("  - {do: gripper, action: close, after: teleoperator.at_pipe}\n", ""))
    done = run(tmp_path / "out", "--scenario", path, *duration)
    assert done.status == EXIT_CHECK_FAILED
    expected = "teleoperator waits for robot.holds, taker waits for teleoperator.lifted, operator waits for taker.holds"
    assert done.summary["reason"] == f"not everything was done in the scenario's 100 s: {expected}"
    assert done.summary["sim_s"] < 100


def test_an_unfinished_program_is_reported_with_its_step(tmp_path):
    done = run(tmp_path / "out", "--scenario", variant(tmp_path, "mirror", ("duration_s: 60", "duration_s: 20")))
    assert re.search(
        r"done in the scenario's 20 s: person is at step \d+ of 22, operator is done", done.summary["reason"]
    )


# ---- each criterion can fail


def test_water_misses_the_glass_when_tilted_too_early(tmp_path):
    """If the operator selects the task pour without the upright approach, the glass tilts on its way to the person's
    glass. The amount spilled in a single run is chaotic, but in the runs with both seeds together less than 90 % is
    caught; `make experiments` requires 95 %."""
    path = variant(tmp_path, "pour", ("- {do: select, task: upright}", "- {do: select, task: pour}"))
    runs = {seed: run(tmp_path / f"out-{seed}", "--scenario", path, "--seed", seed) for seed in (2, 5)}
    outcomes = (
        Outcome(Job("pour", seed, done.out), done.summary["result"], "", done.summary) for seed, done in runs.items()
    )
    together = Condition("pour", None, tuple(outcomes))
    assert not together.passed and together.caught_percent < 90
    assert any("water_caught" in failed(done) for done in runs.values())


FEW_PARTICLES = ("particles: 160", "particles: 10")  # the particles do not affect the arm's motion


@pytest.mark.parametrize("off_mm", [(10, 0, 0), (-10, 0, 0), (0, 10, 0), (0, -10, 0), (0, 0, 10), (0, 0, -10)], ids=str)
def test_an_aim_that_is_10_mm_off_fails(tmp_path, off_mm):
    """If the robot pours 10 mm off, the check of the aim fails, even if the wide glass still catches the water. The
    start position also varies, by 3 mm per axis."""
    path = variant(tmp_path, "pour", FEW_PARTICLES)
    offset_m = np.array([0, -0.06, 0]) + np.array(off_mm) / 1e3
    options = [f"--param=start_offset_{axis}_m={value:g}" for axis, value in zip("xyz", offset_m, strict=True)]
    done = run(tmp_path / "out", "--scenario", path, "--seed", 2 + off_mm.index(max(off_mm, key=abs)), *options)
    assert done.status == EXIT_CHECK_FAILED
    assert "aim" in failed(done)
    assert 7 < values(done)["aim"] < 10 + 6


@pytest.mark.skipif(not RECORDINGS.is_dir(), reason=f"needs recordings: no folder {RECORDINGS}")
def test_the_glasses_do_not_collide_on_a_hand_that_turns_and_moves_far(tmp_path):
    """The glasses stay apart while the hand turns by 90 degrees and moves by 1.3 m, mostly upwards. In an earlier
    version, in which the hand's rotation was scaled by 1/20 instead of 1/50, the clearance was only 0.3 mm."""
    path = variant(tmp_path, "pour", FEW_PARTICLES)
    done = run(tmp_path / "out", "--scenario", path, "--tracker", RECORDINGS / "ethz_handheld1.csv")
    assert values(done)["clearance"] > 4 and not {"clearance", "aim"} & failed(done)


def test_gripper_released_early_drops_the_pipe(tmp_path):
    path = variant(
        tmp_path, "teleop",
        ("action: open, after: taker.holds, delay_s: 0.2", "action: open, after: teleoperator.lifted, delay_s: 0.2"),
    )  # fmt: skip
    done = run(tmp_path / "out", "--scenario", path)
    assert done.status == EXIT_CHECK_FAILED
    assert {"pipe_drops", "pipe_with_taker"} <= failed(done)
    assert any(event["name"] == "pipe.dropped" for event in done.summary["events"])


def test_a_recorded_hand_that_moves_the_pipe_into_its_stand_fails_with_the_reason(tmp_path):
    """At the scale that the scenario's step `play` sets, a motion of 2 m down and forward becomes 80 mm, twice the
    height to which the pipe is lifted. The teleoperator cannot bring a dropped pipe to the taker, so the run ends early
    instead of waiting for the end of the scenario."""
    recording = tmp_path / "hand.csv"
    recording.write_text(
        recording_csv(*(f"{0.01 * i:.2f},{0.01 * i:.2f},0,{-0.01 * i:.2f},1,0,0,0" for i in range(201)))
    )
    done = run(tmp_path / "out", "--scenario", experiment("teleop"), "--tracker", recording)
    assert done.status == EXIT_CHECK_FAILED
    (dropped_s,) = (event["t_s"] for event in done.summary["events"] if event["name"] == "pipe.dropped")
    why = "teleoperator: cannot bring pipe.far to taker's grip: it has fallen"
    assert done.summary["reason"] == f"pipe.dropped at {dropped_s:.2f} s; {why}"
    assert {"pipe_drops", "pipe_with_taker"} <= failed(done) and done.summary["sim_s"] < 20


def test_gripper_released_early_drops_the_baton(tmp_path):
    path = variant(tmp_path, "handover", ("action: open, after: person.holds, delay_s: 0.2", "action: open, at_s: 1"))
    done = run(tmp_path / "out", "--scenario", path)
    assert done.status == EXIT_CHECK_FAILED
    assert {"baton_drops", "baton_with_person"} <= failed(done)


def test_without_the_latch_the_robot_does_not_follow(tmp_path):
    """Without the latch, the robot keeps mirroring, so it moves against the person's motion along x."""
    path = variant(
        tmp_path, "mirror",
        ("  - {do: latch, name: latched, after: [robot.holds, person.holds]}\n", ""),
        ("after: operator.latched, delay_s: 0.3", "after: person.holds, delay_s: 0.3"),
        *((f"measure: {measure}, by: person, from: operator.latched", f"measure: {measure}, by: person")
          for measure in ("force_rms", "force_peak")),
        ("measure: relation_rms, by: person, from: operator.latched",
         "measure: relation_rms, by: person, from: person.holds"),
        ("measure: following_rms, from: operator.latched", "measure: following_rms, from: person.holds"),
    )  # fmt: skip
    done = run(tmp_path / "out", "--scenario", path)
    assert done.status == EXIT_CHECK_FAILED
    assert "goes_along" in failed(done)


IDENTITY = [f"--param=gain_{part}{axis}_per_s=1" for part in ("", "dual_") for axis in "wxyz"]
SEARCHED = [f"--param={name}={value:g}" for name, value in PAPER_GAINS]


@pytest.mark.parametrize(
    ("name", "gains", "criteria"),
    [
        ("mirror", IDENTITY, {"same_side", "same_height"}),
        ("crank", IDENTITY, {"turns", "force_rms"}),
        ("mirror", SEARCHED, {"force_rms", "following"}),
    ],
)
def test_the_papers_law_with_its_published_gains_fails(tmp_path, name, gains, criteria):
    """With K = 1 and lengths in metres, the orientation, which four joints cannot follow, dominates the error. With the
    best K found, the robot follows but pulls at the person's hand. Each criterion fails because of its measured value,
    not because there is no measurement."""
    done = run(tmp_path / "out", "--scenario", experiment(name), "--paper-law", *gains)
    assert done.status == EXIT_CHECK_FAILED
    assert criteria <= failed(done), values(done)
    assert all(values(done)[criterion] is not None for criterion in criteria)


CARRY = "      - {do: move, name: forward, by_m: [0.02, 0, 0], duration_s: 2}\n"
DO_NOT_TILT = ("name: pouring, task: pour, after", "name: pouring, task: upright, after")


@pytest.mark.parametrize(
    ("name", "change", "criteria"),
    [
        ("pour", DO_NOT_TILT, {"glass_tilt", "water_poured"}),
        ("mirror", (CARRY, CARRY + "      - {do: release}\n"), {"carried_for"}),
        ("mirror", (CARRY, CARRY.replace("0.02, 0, 0], duration_s: 2", "0.03, 0, 0], duration_s: 0.1")),
         {"force_peak"}),
        ("crank", ("turns: 3.05", "turns: 2.5"), {"turns"}),
        ("crank", ("elbow_m: [0.60, -0.16, -0.06]", "elbow_m: [0.60, -0.16, -0.06]\n    grip_force_limit_N: 0.7"),
         {"handle_drops"}),
    ],
)  # fmt: skip
def test_each_other_criterion_can_fail(tmp_path, name, change, criteria):
    """The other criteria fail if the glass is never tilted, or if the hand releases too early, moves too fast, turns
    too little or is too weak."""
    done = run(tmp_path / "out", "--scenario", variant(tmp_path, name, change))
    assert done.status == EXIT_CHECK_FAILED
    assert criteria <= failed(done), values(done)
    assert all(values(done)[criterion] is not None for criterion in criteria)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_robot_that_does_not_follow_cannot_pour(tmp_path, seed):
    """If the robot hardly follows the hand, the two glasses collide or the water misses the person's glass."""
    done = run(tmp_path / "out", "--scenario", experiment("pour"), "--seed", seed, "--param", "motion_scale=0.01")
    assert done.status == EXIT_CHECK_FAILED and failed(done) & {"clearance", "water_caught"}


def test_mirrored_motion_of_the_measured_robot(tmp_path):
    """When the person moves along +x, the robot moves along -x by the same distance. Their lateral and vertical motions
    are equal. The displacements, computed from the trace, agree within 5 % of 30 mm."""
    done = run(tmp_path / "out", "--scenario", experiment("mirror"), "--seed", 5).require_pass()
    names = done.trace.open().readline().rstrip().split(",")
    columns = {
        name: names.index(name)
        for name in ("t_s", "hand_x_m", "hand_y_m", "hand_z_m", "person_x_m", "person_y_m", "person_z_m")
    }
    rows = [line.split(",") for line in done.trace.read_text().splitlines()[1:]]
    at = {
        event["name"]: round(1000 * event["t_s"])
        for event in json.loads((done.out / "summary.json").read_text())["events"]
    }

    def way(who: str, axis: str, start: str, end: str) -> float:
        column = columns[f"{who}_{axis}_m"]
        return 1e3 * (float(rows[at[end]][column]) - float(rows[at[start]][column]))

    for axis, sign, start, end in (
        ("x", -1, "person.home", "person.back_settled"),
        ("y", +1, "operator.started", "person.right_settled"),
        ("z", +1, "operator.started", "person.up_settled"),
    ):
        person, robot = way("person", axis, start, end), way("hand", axis, start, end)
        assert abs(person) == pytest.approx(30, abs=0.5)
        assert robot == pytest.approx(sign * person, abs=1.5)
