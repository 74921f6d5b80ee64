"""Checks the campaign of experiments and the search for gains: which runs are made, which files are written, and the
messages. The runs use a fake simulator, which passes, fails, refuses its arguments or hangs as each test requests."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import synthetic_run
from comanip.parameters import all_parameters
from comanip_dev.experiments import gain_search
from comanip_dev.experiments.__main__ import RESULT_FILES, main
from comanip_dev.experiments.campaign import INPUTS_FILE, CampaignError, Job, run_jobs
from comanip_dev.experiments.jobs import RECORDING_SEEDS, RECORDINGS, RECORDINGS_FOLDER
from comanip_dev.experiments.paper_gains import PAPER_GAINS
from comanip_dev.experiments.table import DECISIVE, Figure, figure_lines
from simulation import EXPERIMENTS, PATIENCE_S, experiment

FAKE = """#!{python} -IS
import json, os, sys, time
options = dict(zip(sys.argv[1::1], sys.argv[2::1]))
name, seed, out = options["--scenario"], int(options["--seed"]), options["--out"]
how = os.environ.get("FAKE_" + name.upper(), "")
if how == "hang":
    open(os.environ["FAKE_PIDS"], "a").write(str(os.getpid()) + "\\n")
    time.sleep(60)
if how == "refuse":
    print("comanip-sim: no such thing", file=sys.stderr)
    sys.exit(2)
if how == "mute":
    sys.exit(0)
paper = "--paper-law" in sys.argv
time.sleep(0.02 * (seed % 2))  # so that runs end out of order
failed = how == "fail" and seed == 2 and not paper
open(os.path.join(os.path.dirname(sys.argv[0]), "runs"), "a").write(out + "\\n")
caught = json.loads(os.environ.get("FAKE_CAUGHT", "[60, 60, 60]"))[seed - 1] if "--tracker" in sys.argv else 60
summary = {{
    "scenario": name, "seed": seed, "result": "fail" if failed else "pass",
    "reason": "turns is 1, expected at least 3" if failed else "all checks passed",
    "tracking": {{"rms_position_mm": 30.0 if paper else float(seed), "rms_orientation_deg": 2.0}},
    "people": [{{"name": "a", "force_rms_N": 1.5, "force_peak_N": 4.0}},
               {{"name": "b", "force_rms_N": None, "force_peak_N": None}}],
    "checks": [{{"name": "turns", "value": 3.0 + seed, "limit": 3, "unit": "turn", "pass": not failed}}],
    "water": {{"particles": 160, "poured": 60, "in_person_cup": caught}} if name == "pour" else None,
    "wall_s": 2.5,
    "argv": sys.argv[1:],
}}
json.dump(summary, open(out + "/summary.json", "w"))
open(out + "/bus.log", "w").write("frames")
open(out + "/trace.csv", "w").write("ticks")
sys.exit(1 if failed else 0)
"""


@pytest.fixture
def simulator(tmp_path) -> Path:
    path = tmp_path / "fake-sim"
    path.write_text(FAKE.format(python=sys.executable))
    path.chmod(0o755)
    return path


@pytest.fixture
def recordings(tmp_path) -> Path:
    folder = tmp_path / "hand_motion"
    folder.mkdir()
    for recording in RECORDINGS:
        for name in filter(None, (recording.file, recording.second)):
            (folder / name).write_text("")
    return folder


def run(simulator: Path, out: Path, *more: object) -> int:
    return main(["--seeds", "2", "--out", str(out), "--simulator", str(simulator), *map(str, more)])


# ---- experiments


def test_results_are_complete_and_in_order(tmp_path, simulator, recordings, capsys):
    assert run(simulator, tmp_path / "out", "--recordings", recordings) == 0
    results = json.loads((tmp_path / "out" / "experiments.json").read_text())
    assert all(list(r) == ["scenario", "seed", "recording", "result", "reason", "checks"] for r in results)
    seeds = [(name, seed, None) for name in EXPERIMENTS for seed in (1, 2)]
    played = [(r.scenario, seed, r.file) for r in RECORDINGS for seed in RECORDING_SEEDS]
    assert [(r["scenario"], r["seed"], r["recording"]) for r in results] == seeds + played
    assert results[1]["checks"][0] == {"name": "turns", "value": 5.0, "limit": 3, "unit": "turn", "pass": True}
    text = capsys.readouterr().out
    assert re.search(r"crank +│ +2/2 │ turns \[turn\] +│ +4.5 │ +4 │ >= 3", text), text
    assert "37 of 37 passed" in text
    recorded = len(RECORDING_SEEDS) * 2.5
    for scenario in ("pour", "teleop", "handover"):
        count = sum(r.scenario == scenario for r in RECORDINGS)
        assert f"{scenario} 5 s; " in text and f"{scenario}, recordings {count * recorded:.0f} s" in text
    assert "paper's law 25 s\n" in text


def test_recordings_are_given_to_both_people(tmp_path, simulator, recordings):
    run(simulator, tmp_path / "out", "--recordings", recordings)
    summary = tmp_path / "out" / "teleop" / "recording-kth_ho_sample_giver-seed-02" / "summary.json"
    command = json.loads(summary.read_text())["argv"]
    assert command[command.index("--tracker") + 1] == str(recordings / "kth_ho_sample_giver.csv")
    assert command[command.index("--tracker-second") + 1] == str(recordings / "kth_ho_sample_taker.csv")
    assert "--paper-law" not in command and "--param" not in command


def test_missing_recordings_are_reported(tmp_path, simulator, recordings, capsys):
    assert run(simulator, tmp_path / "out", "--recordings", tmp_path / "none") == 0
    assert f"recordings were not run: there is no folder {tmp_path / 'none'}" in " ".join(
        capsys.readouterr().out.split()
    )
    (recordings / RECORDINGS[0].file).unlink()
    assert run(simulator, tmp_path / "out", "--recordings", recordings) == 2
    assert f"{recordings}: lacks {RECORDINGS[0].file}" in capsys.readouterr().err


@pytest.mark.parametrize("keep", [False, True])
def test_logs_are_kept_only_when_asked_for(tmp_path, simulator, keep):
    run(simulator, tmp_path / "out", "--recordings", tmp_path / "none", *(["--keep"] if keep else []))
    files = {path.name for path in (tmp_path / "out" / "pour" / "seed-01").iterdir()}
    assert files == {"summary.json", INPUTS_FILE} | ({"bus.log", "trace.csv"} if keep else set())


def test_both_laws_in_one_table(tmp_path, simulator):
    run(simulator, tmp_path / "out", "--recordings", tmp_path / "none")
    rows = json.loads((tmp_path / "out" / "laws.json").read_text())
    assert [row["scenario"] for row in rows] == list(EXPERIMENTS)
    ours, paper = rows[0]["default"], rows[0]["paper"]
    assert ours["rms_position_mm"] == 1.5 and paper["rms_position_mm"] == 30.0
    assert (ours["force_rms_N"], ours["force_peak_N"], ours["passed"], ours["runs"]) == (1.5, 4.0, 2, 2)
    table = (tmp_path / "out" / "laws.md").read_text()
    assert "| pour | paper | 30 | 2 | 1.5 / 4 | 2 of 2 |" in table


def test_the_papers_law_is_used(tmp_path, simulator):
    run(simulator, tmp_path / "out", "--recordings", tmp_path / "none")
    command = json.loads((tmp_path / "out" / "crank" / "paper-law-seed-02" / "summary.json").read_text())["argv"]
    written = [text for option, text in zip(command, command[1:], strict=False) if option == "--param"]
    assert "--paper-law" in command and len(written) == 19
    value = {name: float(number) for name, _, number in (text.partition("=") for text in written)}
    assert value == pytest.approx(dict(PAPER_GAINS)) and value["error_frame"] == 0.0
    assert all(value[name] == 1.0 for name in value if name.startswith("weight_"))


def test_a_failed_run_is_named_and_fails(tmp_path, simulator, monkeypatch, capsys):
    monkeypatch.setenv("FAKE_CRANK", "fail")
    assert run(simulator, tmp_path / "out", "--recordings", tmp_path / "none") == 1
    text = capsys.readouterr().out
    assert "FAILED crank, seed 2: turns is 1, expected at least 3" in text and "9 of 10 passed" in text
    results = json.loads((tmp_path / "out" / "experiments.json").read_text())
    assert [r["result"] for r in results if r["scenario"] == "crank"] == ["pass", "fail"]


@pytest.mark.parametrize(("caught", "passed"), [([57, 57, 57], True), ([55, 56, 60], True), ([56, 55, 59], False)])
def test_pouring_is_judged_over_all_seeds_of_a_condition(
    tmp_path, simulator, recordings, monkeypatch, capsys, caught, passed
):
    """The runs with all three seeds together must catch at least 95 % of 3 x 60 particles, i.e. 171. If they do not,
    the campaign fails, even though each single run passes its own check."""
    monkeypatch.setenv("FAKE_CAUGHT", json.dumps(caught))
    assert run(simulator, tmp_path / "out", "--recordings", recordings) == (0 if passed else 1)
    text = capsys.readouterr().out
    assert "37 of 37 passed" in text
    line = (
        "FAILED pour, kul_pour1_com.csv, 3 seeds together: "
        "170 of 180 particles caught (94.44 %), expected at least 95 %"
    )
    assert (line in text) == (not passed)
    conditions = json.loads((tmp_path / "out" / "conditions.json").read_text())
    poured = [r.file for r in RECORDINGS if r.scenario == "pour"]
    assert [(c["recording"], c["runs"], c["poured"]) for c in conditions] == [(None, 2, 120)] + [
        (f, 3, 180) for f in poured
    ]
    assert [c["caught"] for c in conditions[1:]] == [sum(caught)] * len(poured)
    assert all(c["pass"] == passed and c["limit_percent"] == 95.0 for c in conditions[1:])


def test_a_pour_without_particles_fails(tmp_path, simulator, monkeypatch, capsys):
    monkeypatch.setenv("FAKE_POUR", "refuse")
    assert run(simulator, tmp_path / "out", "--recordings", tmp_path / "none") == 1
    assert "FAILED pour, 2 seeds together: 0 of 0 particles caught (- %)" in capsys.readouterr().out


def runs_made(simulator: Path) -> list[str]:
    """Returns the output folders of the runs made since the last call, relative to the campaign's folder."""
    path = simulator.parent / "runs"
    made = path.read_text().split() if path.exists() else []
    path.unlink(missing_ok=True)
    return ["/".join(Path(out).parts[-2:]) for out in made]


def test_only_what_changed_is_run_again(tmp_path, simulator, recordings, monkeypatch, capsys):
    out = tmp_path / "out"
    arguments = ("--recordings", recordings)
    monkeypatch.setenv("FAKE_CRANK", "fail")
    assert run(simulator, out, *arguments) == 1 and len(runs_made(simulator)) == 47
    first = {name: (out / name).read_text() for name in RESULT_FILES}
    capsys.readouterr()
    assert run(simulator, out, *arguments) == 1 and runs_made(simulator) == []
    assert "47 of 47 runs are already finished with the same inputs" in capsys.readouterr().out
    assert {name: (out / name).read_text() for name in RESULT_FILES} == first
    (recordings / "kul_pour1_com.csv").write_text("another")
    run(simulator, out, *arguments)
    assert sorted(runs_made(simulator)) == [f"pour/recording-kul_pour1_com-seed-0{seed}" for seed in RECORDING_SEEDS]
    (out / "mirror" / "seed-01" / "summary.json").unlink()
    run(simulator, out, *arguments)
    assert runs_made(simulator) == ["mirror/seed-01"]
    run(simulator, out, *arguments, "--keep")
    assert len(runs_made(simulator)) == 47, "--keep must repeat the runs whose logs were not kept"
    simulator.write_text(simulator.read_text() + "# another program\n")
    run(simulator, out, *arguments)
    assert len(runs_made(simulator)) == 47


def test_a_scenario_that_changed_is_run_again(tmp_path, simulator):
    scenarios = tmp_path / "repository" / "sim" / "scenarios"
    scenarios.mkdir(parents=True)
    program = tmp_path / "repository" / "build" / "host" / "comanip-sim"
    program.parent.mkdir(parents=True)
    simulator.rename(program)
    (scenarios / "mirror.yaml").write_text("name: mirror")
    run(program, tmp_path / "out", "--recordings", tmp_path / "none")
    runs_made(program)
    (scenarios / "mirror.yaml").write_text("name: mirror  # and more")
    run(program, tmp_path / "out", "--recordings", tmp_path / "none")
    assert sorted(runs_made(program)) == [f"mirror/{law}seed-0{seed}" for law in ("paper-law-", "") for seed in (1, 2)]


def test_a_refused_run_quotes_the_simulators_message(tmp_path, simulator, monkeypatch, capsys):
    monkeypatch.setenv("FAKE_POUR", "refuse")
    assert run(simulator, tmp_path / "out", "--recordings", tmp_path / "none") == 1
    assert "FAILED pour, seed 1: exit status 2: comanip-sim: no such thing" in capsys.readouterr().out


def test_an_earlier_summary_is_not_used_for_a_run_that_wrote_none(tmp_path, simulator, monkeypatch):
    out = tmp_path / "seed-01"
    out.mkdir()
    (out / "summary.json").write_text(json.dumps(synthetic_run.summary("pour")))
    monkeypatch.setenv("FAKE_POUR", "mute")
    (outcome,) = run_jobs([Job("pour", 1, out)], simulator)
    assert outcome.result == "error" and "no summary" in outcome.reason


def test_an_interrupt_stops_the_children_and_writes_nothing(tmp_path, simulator):
    out, pids = tmp_path / "out", tmp_path / "pids"
    out.mkdir()
    (out / "experiments.json").write_text("[]")  # as left by an earlier campaign
    command = [sys.executable, "-m", "comanip_dev.experiments", "--seeds", "2", "--out", out, "--simulator", simulator]
    environment = {**os.environ, "FAKE_TELEOP": "hang", "FAKE_PIDS": str(pids)}
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + PATIENCE_S
    while not (pids.exists() and len(pids.read_text().split()) == 2) and time.monotonic() < deadline:
        time.sleep(0.02)
    process.send_signal(signal.SIGTERM)
    _, error = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    again = "; run the same command again to continue"
    assert error == f"comanip_dev.experiments: interrupted: results are incomplete and not written{again}\n"
    for pid in pids.read_text().split():
        with pytest.raises(ProcessLookupError):
            os.kill(int(pid), 0)
    assert not list(out.glob("*.json")) and not list(out.glob("*.md"))
    done = runs_made(simulator)
    assert done and run(simulator, out, "--recordings", tmp_path / "none") == 0
    assert not set(done) & set(runs_made(simulator)), "finished runs are not repeated"


@pytest.mark.parametrize("arguments", [["--seeds", "0"], ["--seeds", "x"], ["--jobs", "-1"]])
def test_wrong_use(tmp_path, capsys, arguments):
    with pytest.raises(SystemExit) as stop:
        main(["--out", str(tmp_path), *arguments])
    assert stop.value.code == 2
    assert "expected a whole number of at least 1" in capsys.readouterr().err


def test_without_a_simulator(tmp_path, capsys):
    assert run(tmp_path / "none", tmp_path / "out", "--recordings", tmp_path / "none") == 2
    assert "there is no simulator: run `make build` first" in capsys.readouterr().err


def test_a_run_that_hangs_is_stopped(tmp_path, simulator, monkeypatch):
    monkeypatch.setenv("FAKE_POUR", "hang")
    monkeypatch.setenv("FAKE_PIDS", str(tmp_path / "pids"))
    (outcome,) = run_jobs([Job("pour", 1, tmp_path / "run")], simulator, timeout_s=0.3)
    assert (outcome.result, outcome.reason) == ("error", "stopped: not done after 0.3 s of wall time")


def test_figures_without_measurements():
    assert figure_lines([], [Figure("turns", True)]) == [("turns", "-", "-", "-")]


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_decisive_figures_are_checks_of_the_scenario(name):
    """Each decisive figure has a check in the scenario, and the kind of its limit (at_least or at_most) shows whether
    higher is better."""
    text = experiment(name).read_text()
    for figure in DECISIVE[name]:
        found = re.search(rf"name: {figure.check},.*?(at_least|at_most):", text, re.DOTALL)
        assert found, f"{name} has no check {figure.check}"
        assert figure.higher_is_better == (found[1] == "at_least")


@pytest.mark.skipif(not RECORDINGS_FOLDER.is_dir(), reason=f"there is no folder {RECORDINGS_FOLDER}")
def test_the_listed_recordings_exist():
    for recording in RECORDINGS:
        assert (RECORDINGS_FOLDER / recording.file).is_file()
        assert recording.second is None or (RECORDINGS_FOLDER / recording.second).is_file()


# ---- the search for gains


def firmware_ranges() -> dict[str, tuple[float, float]]:
    return {name: (parameter.minimum, parameter.maximum) for name, parameter in all_parameters().items()}


@pytest.mark.parametrize("law", ["paper", "ours"])
def test_candidates_are_within_the_firmwares_ranges(law):
    ranges = firmware_ranges()
    grid = gain_search.coarse_grid(law)
    assert len(set(grid)) == len(grid) > 20
    for candidate in [*grid, *(n for c in grid for n in gain_search.neighbours(c))]:
        for name, value in candidate.parameters:
            low, high = ranges[name]
            assert low <= value <= high * (1 + 1e-9), (name, value)


def test_the_two_laws():
    paper = dict(gain_search.Candidate("paper", 3.0, 100.0, 1e-4).parameters)
    assert (paper["error_frame"], paper["gain_x_per_s"], paper["gain_dual_x_per_s"]) == (0.0, 3.0, pytest.approx(300.0))
    assert {paper[name] for name in paper if name.startswith("weight_")} == {1.0}
    assert paper["prediction"] == 0.0
    ours = dict(gain_search.Candidate("ours", 50.0, 1e4, 0.0).parameters)
    assert ours == {"prediction": 1.0, "following_gain_per_s": 50.0, "orientation_weight_m2": pytest.approx(1e-4)}


def test_share_at_the_acceleration_limit():
    """The share is a quarter, because the limit of 25 rad/s^2 is 0.025 rad/s per tick, and 100 of the 400 steps reach
    it."""
    steps = np.zeros(400)
    steps[:100] = 0.025
    rate = np.concatenate([[np.nan], [0.0], np.cumsum(steps)])
    trace = {f"dq{i}_command_radps": np.round(rate if i == 2 else 0.0 * rate, 3) for i in range(4)}
    assert gain_search.acceleration_share(trace) == pytest.approx(0.25)


def test_a_failed_check_outweighs_a_better_tracking():
    good = (2.0, 10.0, 0.0, 1.0, 0.0)
    assert gain_search.run_score(good) == pytest.approx(0.4 + 0.5 + 0.0 + 0.2)
    assert gain_search.run_score((0.0, 0.0, 0.0, 0.0, 1.0)) > gain_search.run_score(good)
    assert gain_search.run_score((np.nan, np.nan, np.nan, np.nan, 1.0)) == pytest.approx(10.0)


def test_the_search_finds_the_minimum_of_a_known_bowl(capsys):
    """The search finds the minimum at gain 14, ratio 32 and damping 3e-4, which lies half a step away from the
    nearest points of the coarse grid."""

    def bowl(candidate: gain_search.Candidate, seeds: int) -> gain_search.Score:
        logs = np.log([candidate.gain_per_s / 14.0, candidate.ratio / 32.0, candidate.damping / 3e-4])
        return gain_search.Score(float((logs**2).sum()), 0.0, 0.0, 0.0, 0.0, seeds, seeds)

    search = gain_search.Search(bowl, budget_s=60.0)
    search.law("paper", seeds=3, end_s=time.monotonic() + PATIENCE_S)
    confirmed = [t for t in search.tried if t.stage == "confirmed"]
    coarse = [t for t in search.tried if t.stage == "coarse"]
    assert len(coarse) == len(gain_search.coarse_grid("paper")) and len(confirmed) == gain_search.BEST
    assert min(t.score.score for t in confirmed) < 0.8 * min(t.score.score for t in coarse)
    assert all(t.score.runs == 3 for t in confirmed)
    assert f"{len(coarse)} of {len(coarse)} points" in gain_search.markdown(search.tried, ["pour"])


def test_a_search_ends_with_its_budget_and_writes_what_it_tried(tmp_path, simulator):
    arguments = ["--out", tmp_path / "out", "--simulator", simulator, "--budget-s", "1", "--scenarios", "crank"]
    assert gain_search.main([str(a) for a in [*arguments, "--seeds", "1"]]) == 0
    rows = (tmp_path / "out" / "tried.csv").read_text().splitlines()
    assert rows[0].split(",") == list(gain_search.COLUMNS)
    stages = {tuple(row.split(",")[:2]) for row in rows[1:]}
    assert {(law, stage) for law in ("paper", "ours") for stage in ("coarse", "confirmed")} <= stages
    assert "points of the coarse grid tried" in (tmp_path / "out" / "gains.md").read_text()
    assert not (tmp_path / "out" / "runs").exists()


def test_a_search_without_any_successful_run_reports_it(tmp_path, simulator, monkeypatch, capsys):
    monkeypatch.setenv("FAKE_CRANK", "refuse")
    arguments = ["--out", tmp_path / "out", "--simulator", simulator, "--scenarios", "crank"]
    assert gain_search.main([str(a) for a in arguments]) == 2
    assert "no run could be scored: crank, seed 1: exit status 2: comanip-sim: no such" in capsys.readouterr().err
    assert not (tmp_path / "out" / "tried.csv").exists()


def test_no_jobs_without_a_simulator(tmp_path):
    with pytest.raises(CampaignError, match="there is no simulator"):
        run_jobs([], tmp_path / "none")
