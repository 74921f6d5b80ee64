"""The verdict on a run: no check is left out silently, no control law avoids being judged, and the last line of the
output names the parts of the run that were not judged."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import bus_log
import numpy as np
import pytest
from hoap3 import PULSES_PER_RAD
from simulation import (
    EXIT_CHECK_FAILED,
    EXIT_PASS,
    EXIT_WRONG_USE,
    SCENARIOS,
    SIMULATOR,
    Run,
    call,
    modes,
    recording_csv,
    run,
)

OF_THE_SCRIPT = {
    "pour": ("settled_at_spot_1", "glass_tilt_at_spot_1", "settled_at_spot_2", "settled_at_spot_3"),
    "teleop": ("forward", "forward_and_left", "up", "back_at_start", "wrist_turned", "wrist_turned_in_place"),
    "mirror": ("mirrored_back", "same_side", "same_height", "at_the_grasp", "carried"),
}  # fmt: skip
JUDGES = ("followable_share", "followable_rms_position", "followable_max_position")


def checks(done: Run) -> dict[str, dict]:
    return {check["name"]: check for check in done.summary["checks"]}


def still_hand(tmp_path, *, x_m=0.0):
    recording = tmp_path / "hand.csv"
    recording.write_text(recording_csv(*(f"{0.01 * i:.2f},{x_m},0,0,1,0,0,0" for i in range(200))))
    return recording


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_a_complete_script_has_all_its_checks(tmp_path, scenario):
    done = run(tmp_path / "out", "--scenario", scenario).require_pass()
    assert {*OF_THE_SCRIPT[scenario], *JUDGES} <= checks(done).keys()
    assert "left out" not in done.summary["reason"]


@pytest.mark.parametrize("gap_s", [1.3, 1.0])  # the gap covers all or 0.9 s of the second that is judged
def test_check_that_could_not_be_measured_fails(tmp_path, gap_s):
    """In hold there is no target at which the arm could settle, so the check fails."""
    gap = ("--gap", f"2.4:{gap_s}")
    done = run(tmp_path / "out", "--scenario", "pour", *gap)
    assert done.status == EXIT_CHECK_FAILED
    spot = checks(done)["settled_at_spot_1"]
    assert (spot["value"], spot["pass"]) == (None, False)
    assert "settled_at_spot_1 could not be measured" in done.summary["reason"]
    output = call("--scenario", "pour", *gap, "--out", tmp_path / "output").stdout
    (row,) = (line for line in output.splitlines() if line.startswith("settled_at_spot_1"))
    assert "not measured" in row and row.endswith("FAIL")


def test_a_shortened_run_reports_what_it_left_out(tmp_path):
    done = run(tmp_path / "out", "--scenario", "teleop", "--duration", 6).require_pass()
    left_out = set(OF_THE_SCRIPT["teleop"]) - {"forward", "forward_and_left"} | {"followable_share"}
    assert not left_out & checks(done).keys()
    assert {"forward", "forward_and_left"} <= checks(done).keys()
    assert f"{len(left_out)} left out: they lie beyond the end" in done.summary["reason"]


def test_without_the_trace_only_checks_that_need_it_are_left_out(tmp_path):
    done = run(tmp_path / "out", "--scenario", "pour", "--param", "trace=0").require_pass()
    assert "glass_tilt_at_spot_1" in checks(done)
    assert "6 left out: they need the target" in done.summary["reason"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["--param", "acceleration_limit_radps2=1"],  # the arm is at its acceleration limit whenever it moves
        ["--dropout", 0.5],  # the arm is repeatedly in hold
        ["--param", "speed_fraction=0.02"],
    ],
    ids=lambda arguments: "=".join(map(str, arguments)),
)
def test_an_arm_that_cannot_follow_is_not_excused(tmp_path, arguments):
    done = run(tmp_path / "out", "--scenario", "pour", *arguments)
    assert done.status == EXIT_CHECK_FAILED
    judged = checks(done)  # fails for too little followable motion, or for following it badly
    assert not (judged["followable_share"]["pass"] and judged["followable_rms_position"]["pass"])


@pytest.mark.parametrize(("gain", "pass_"), [(2, False), (100, True)])
def test_followable_share_does_not_depend_on_the_gain(tmp_path, gain, pass_):
    """A slow law misses the target, but the gain does not change how much of the run is judged."""
    axes = [f"gain_{part}{axis}_per_s" for part in ("", "dual_") for axis in "wxyz"]
    changed = checks(
        run(
            tmp_path / "changed",
            "--scenario",
            "teleop",
            "--param=prediction=0",
            *(f"--param={name}={gain}" for name in axes),
        )
    )
    normal = checks(run(tmp_path / "normal", "--scenario", "teleop"))
    share = normal["followable_share"]["value"]
    assert changed["followable_share"]["value"] == pytest.approx(share, abs=25) and share > 60
    assert changed["followable_share"]["value"] > 60
    assert changed["followable_rms_position"]["pass"] == pass_


# ---- recordings


def test_an_unjudged_recording_is_reported(tmp_path):
    recording = still_hand(tmp_path)
    arguments = ("--scenario", "teleop", "--tracker", recording, "--duration", 2)
    done = run(tmp_path / "out", *arguments).require_pass()
    assert "tracking was not judged: " in done.summary["reason"] and "needs 1 s" in done.summary["reason"]
    output = call(*arguments, "--out", tmp_path / "output").stdout
    (row,) = (line for line in output.splitlines() if line.startswith("followable_rms_position"))
    assert "not judged" in row


def moving_hand(folder: Path, *way_m: np.ndarray) -> Path:
    """Writes a recording of 5 s at 100 Hz with the given displacements along x, y and z."""
    path = folder / "hand.csv"
    rows = zip(np.arange(500) / 100, *np.broadcast_arrays(*way_m), strict=True)
    path.write_text(recording_csv(*(f"{t:.2f},{x:.4f},{y:.4f},{z:.4f},1,0,0,0" for t, x, y, z in rows)))
    return path


T_S = np.arange(500) / 100
AWAY_AND_STAYING = (1.5 * np.clip(T_S, 0, 1), 0, 0)  # moves away by five times the arm's reach
ROUND_A_LOOP = (0.8 - 0.8 * np.cos(2.5 * T_S), 0.5 * np.sin(2.5 * T_S), 0.6 * np.sin(5 * T_S))


@pytest.mark.parametrize(("way_m", "scale"), [(AWAY_AND_STAYING, 1), (AWAY_AND_STAYING, 0.08), (ROUND_A_LOOP, 1)])
def test_recording_out_of_reach_reports_the_largest_scale_in_reach(tmp_path, way_m, scale):
    """At the reported scale the target is always in reach. At the next larger scale of two significant digits it is
    not."""
    recording = moving_hand(tmp_path, *way_m)

    def scaled(by: float) -> Run:
        return run(tmp_path / f"out-{by:g}", "--scenario", "teleop", "--tracker", recording, "--scale", f"{by:g}")

    reason = scaled(scale).summary["reason"]
    found = re.search(
        r"; target out of reach [\d.]+ of [\d.]+ s, followable for [\d.]+ of [\d.]+ s: try --scale (0\.0\d\d?)$",
        reason,
    )
    assert found, reason
    assert scaled(float(found[1])).summary["reach"]["out_of_reach_s"] == 0
    assert scaled(float(found[1]) + 0.001).summary["reach"]["out_of_reach_s"] > 0


def test_recording_out_of_reach_at_every_scale_gets_no_advice(tmp_path):
    """A recording that moves 8 m away exceeds the arm's 0.28 m even at the smallest scale, 0.01."""
    recording = moving_hand(tmp_path, 8.0 * np.clip(T_S, 0, 1), 0, 0)
    reason = run(tmp_path / "out", "--scenario", "teleop", "--tracker", recording).summary["reason"]
    assert "target out of reach" in reason and "--scale" not in reason


def test_holds_are_reported(tmp_path):
    done = run(tmp_path / "out", "--scenario", "teleop", "--tracker", still_hand(tmp_path), "--gap", "3:100")
    assert ("hold", "tracker_stale") in modes(done)
    assert "1 hold, " in done.summary["reason"] and "cooperation did not resume" in done.summary["reason"]


@pytest.mark.parametrize(
    ("x_m", "arguments", "words"),
    [
        (0.0, ["--mount-translation", "9,0,0"], "all 751 samples are beyond the 8.388 m"),
        (0.0, ["--mount-translation", "4,0,0", "--profile", "classic"], "all 376 samples are beyond the 3.276 m"),
        (0.0, ["--dropout", "1"], "the tracker lost all 751 samples"),
    ],
)
def test_tracker_that_never_sends_a_pose_reports_why(tmp_path, x_m, arguments, words):
    recording = still_hand(tmp_path, x_m=x_m)
    done = run(tmp_path / "out", "--scenario", "pour", "--tracker", recording, "--latency-ms", 0, *arguments)
    assert done.status == EXIT_CHECK_FAILED
    assert done.summary["reason"].startswith("operator: waiting for mode ready")
    assert words in done.summary["reason"]
    samples = 376 if "classic" in arguments else 751
    range_errors = 0 if "--dropout" in arguments else samples
    tracker = done.summary["tracker"]
    assert (tracker["samples"], tracker["lost"], tracker["range_errors"]) == (samples, samples, range_errors)
    assert tracker["longest_gap_ms"] == pytest.approx(3000), "the whole recording is played"


# ---- files


def test_first_row_shows_the_start_posture(tmp_path):
    done = run(tmp_path / "out", "--scenario", "teleop", "--duration", 2)
    names, first = (line.rstrip().split(",") for line in done.trace.open().readlines()[:2])
    q_rad = [float(first[names.index(f"q{i}_rad")]) for i in range(4)]
    assert q_rad == pytest.approx(np.radians([60, -30, -10, -80]), abs=0.5 / PULSES_PER_RAD + 1e-6)


def test_one_folder_serves_one_run_at_a_time(tmp_path):
    out = tmp_path / "out"
    first = subprocess.Popen([SIMULATOR, "--duration", "3600", "--quiet", "--out", out])
    try:
        while not (out / "bus.log.partial").exists():
            assert first.poll() is None
        before = (out / "bus.log.partial").stat().st_ino
        second = run(out, "--duration", 2)
        assert second.status == EXIT_WRONG_USE
        assert second.stderr == f"comanip-sim: {out}: is in use by another run\n"
        assert (out / "bus.log.partial").stat().st_ino == before
    finally:
        first.kill()
        first.wait()
    assert run(out, "--duration", 2).status == EXIT_PASS, "the lock is released when its run ends"


def test_folder_is_named_after_the_scenario(tmp_path):
    assert call("--scenario", "mirror", "--duration", 2, "--quiet", cwd=tmp_path).returncode == EXIT_PASS
    assert (tmp_path / "out" / "mirror" / "summary.json").exists()


# ---- operator options


def test_paper_law_reaches_the_bus_and_param_overrides_it(tmp_path):
    done = run(tmp_path / "out", "--scenario", "pour", "--duration", 2, "--param", "gain_w_per_s=5", "--paper-law")
    access = bus_log.read(done.log)["ParameterAccess"]
    names = access.message.get_signal_by_name("parameter").choices
    sent = [access.message.decode(bytes(row)) for row in access.data]
    written = {str(frame["parameter"]): frame["value"] for frame in sent}
    expected = {name: 4 for name in map(str, names.values()) if name.startswith("gain_")}
    expected |= {name: 1 for name in map(str, names.values()) if name.startswith("weight_")}
    assert written == expected | {"prediction": 0, "error_frame": 0, "gain_w_per_s": 5}
    assert len(expected) == 16


TASK = "constant:0.01,0.02,-0.03:0.8,0.6,0,0:0,0,-0.6,0.8:0.25"


def test_defined_task_replaces_the_scenarios_on_the_bus(tmp_path):
    done = run(tmp_path / "out", "--scenario", "teleop", "--define", TASK).require_pass()
    log = bus_log.read(done.log)
    define = log["TaskDefine"]
    (sent,) = [define.message.decode(bytes(row), decode_choices=False) for row in define.data]
    assert [sent[f"t_task_{axis}_m"] for axis in "xyz"] == pytest.approx([0.01, 0.02, -0.03], abs=1e-6)
    assert [sent[f"q_task_{axis}"] for axis in "wxyz"] == pytest.approx([0.8, 0.6, 0, 0], abs=1e-4)
    assert [sent[f"q_inv_{axis}"] for axis in "wxyz"] == pytest.approx([0, 0, -0.6, 0.8], abs=1e-4)
    assert (sent["form"], sent["blend_s"]) == (0, pytest.approx(0.25))
    ack = [log["CommandAck"].message.decode(bytes(row)) for row in log["CommandAck"].data]
    assert [str(a["command"]) for a in ack] == ["define", "start", "stop"]
    assert all(str(a["result"]) == "accepted" for a in ack)
    assert ack[0]["sequence"] == sent["sequence"]
    task = log["FirmwareStatus"].message.get_signal_by_name("task").choices
    assert str(task[log["FirmwareStatus"].raw("task")[-1]]) == "custom"
    assert not set(OF_THE_SCRIPT["teleop"]) & checks(done).keys()


@pytest.mark.parametrize(("scenario", "clutch_s"), [("teleop", 4.0), ("mirror", 6.5)])
def test_clutch_takes_the_arms_current_pose(tmp_path, scenario, clutch_s):
    """Without prediction, the end effector lags behind its target in the middle of a move. The clutch sets the target
    to the pose of the end effector."""
    done = run(tmp_path / "out", "--scenario", scenario, "--clutch", clutch_s, "--param", "prediction=0")
    log = bus_log.read(done.log)
    command, ack = log["OperatorCommand"], log["CommandAck"]
    names = command.message.get_signal_by_name("command").choices
    (clutch,) = (i for i, value in enumerate(command.raw("command")) if str(names[value]) == "clutch")
    assert 0 <= command.t_s[clutch] - clutch_s < 2e-3
    answers = {frame["sequence"]: frame for frame in (ack.message.decode(bytes(row)) for row in ack.data)}
    answer = answers[command.raw("sequence")[clutch]]
    assert (str(answer["command"]), str(answer["result"])) == ("clutch", "accepted")
    trace = np.genfromtxt(done.trace, delimiter=",", names=True)
    behind_m = np.linalg.norm([trace[f"target_{axis}_m"] - trace[f"hand_{axis}_m"] for axis in "xyz"], axis=0)
    tick = round(1000 * clutch_s)
    assert behind_m[tick - 5 : tick].min() > 6e-4
    assert np.nanmin(behind_m[tick : tick + 4]) < 1.5e-4
    assert "left out: they compare with the start of their window" in done.summary["reason"]
    assert not {"wrist_turned", "carried"} & checks(done).keys()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--clutch", "0.9"], ["--clutch '0.9'", "from 1 to 86400"]),
        (["--clutch", "89.5"], ["--clutch '89.5'", "expected less than 89.5 s"]),
        (["--clutch", "5", "--duration", "5"], ["--clutch '5'", "expected less than 4.5 s"]),
        *((["--define", wrong], [f"--define '{wrong}'", "expected FORM:TX,TY,TZ:"]) for wrong in (
            "", "constant", "constant:0,0,0", "round:0,0,0:1,0,0,0:1,0,0,0:1", "constant:0,0:1,0,0,0:1,0,0,0:1",
            "constant:0,0,9:1,0,0,0:1,0,0,0:1", "constant:0,0,0:2,0,0,0:1,0,0,0:1", "constant:0,0,0:1,0,0,0:0,0,0,0:1",
            "constant:0,0,0:1,0,0,0:1,0,0,0:66", "constant:0,0,0:1,0,0,0:1,0,0,0:1:1",
            "constant:0,0,nan:1,0,0,0:1,0,0,0:1",
        )),
    ],
)  # fmt: skip
def test_wrong_operator_options_give_one_line(tmp_path, arguments, words):
    done = run(tmp_path / "out", *arguments)
    assert done.status == EXIT_WRONG_USE
    assert done.stderr.count("\n") == 1 and done.stderr.startswith("comanip-sim: ")
    for word in words:
        assert word in done.stderr
    assert not (tmp_path / "out").exists()
