"""The simulator's command line: wrong use costs one clear line and nothing else; the options do what they say; exit status,
summary.json and the bus agree."""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
import subprocess
import time

import bus_log
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from simulation import (
    EXIT_CHECK_FAILED,
    EXIT_INTERRUPTED,
    EXIT_PASS,
    EXIT_WRONG_USE,
    FILES,
    REPOSITORY,
    SCENARIOS,
    SIMULATOR,
    Run,
    call,
    modes,
    run,
)

HEADER = "t_s,x_m,y_m,z_m,qw,qx,qy,qz"
GAINS = [f"gain_{part}{axis}_per_s" for part in ("", "dual_") for axis in "wxyz"]


def csv(*rows: str) -> str:
    return "\n".join([HEADER, *rows]) + "\n"


RECORDINGS = {
    "empty.csv": "",
    "header_only.csv": csv(),
    "one_sample.csv": csv("0,0,0,0,1,0,0,0"),
    "words.csv": csv("0,0,0,0,1,0,0,0", "0.01,left,0,0,1,0,0,0"),
    "not_a_number.csv": csv("0,0,0,0,1,0,0,0", "0.01,nan,0,0,1,0,0,0"),
    "backwards.csv": csv("0,0,0,0,1,0,0,0", "0.02,0,0,0,1,0,0,0", "0.01,0,0,0,1,0,0,0"),
    "repeated.csv": csv("0,0,0,0,1,0,0,0", "0.01,0,0,0,1,0,0,0", "0.01,0,0,0,1,0,0,0"),
    "few_columns.csv": csv("0,0,0,0,1,0,0,0", "0.01,0,0,0,1,0,0"),
    "off_unit.csv": csv("0,0,0,0,1,0,0,0", "0.01,0,0,0,2,0,0,0"),
    "wrong_header.csv": "time,x,y,z\n0,0,0,0\n",
    "hand.csv": csv(*(f"{0.01 * i:.2f},{0.0001 * i:.4f},0,0,1,0,0,0" for i in range(100))),
}


@pytest.fixture
def workspace(tmp_path):
    """A folder with recordings, most of them wrong, and a few things that are no recordings."""
    for name, text in RECORDINGS.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "binary.csv").write_bytes(bytes(range(256)))
    (tmp_path / "folder.csv").mkdir()
    return tmp_path


# ---- wrong use

NUMBER_OPTIONS = {
    "duration": ("1.9", "86401"),
    "rate": ("14", "1001"),
    "noise-mm": ("-0.1", "1001"),
    "noise-deg": ("-0.1", "58"),
    "latency-ms": ("-1", "501"),
    "dropout": ("-0.01", "1.01"),
    "scale": ("0", "11"),
    "seed": ("-1", "18446744073709551616"),
    "tracker-clock": ("-1", "4294967296"),
}
NO_NUMBERS = ("nan", "inf", "-inf", "1e999", "1e308", "abc", "", "0x10", "5 ", "1,2")
LISTS = {
    "gap": ("5", "5:", ":1", "-1:1", "1:-1", "nan:1", "1:inf", "1:2:3", "1e308:1", "a:b", ""),
    "mount-translation": ("1", "1,2", "1,2,3,4", "nan,0,0", "1001,0,0", "0,0,-1e308", "a,b,c", ""),
    "mount-rotation": ("1", "0,0,0,0", "1,1,0,0", "nan,0,0,0", "1,0,0", "2,0,0,0", ""),
    "param": ("motion_scale", "=1", "no_such=1", "motion_scale=", "motion_scale=nan", "motion_scale=-1"),
}
# Arguments, and what the line must hold: the thing, the value and what was expected.
WRONG_USE = [
    (["juggle"], ["'juggle'", "expected options"]),
    (["--", "pour"], ["'pour'", "expected options"]),
    (["--fast"], ["'--fast'", "no such option", "--help"]),
    (["-x"], ["'-x'", "no such option", "--help"]),
    (["--help=5"], ["'--help=5'", "takes no value"]),
    (["--scenario", "juggle"], ["--scenario 'juggle'", *SCENARIOS]),
    (["--scenario", ""], ["--scenario ''", *SCENARIOS]),
    (["--scenario", "po\nur"], ["--scenario 'po?ur'", *SCENARIOS]),
    (["--scenario", 5000 * "x"], ["--scenario 'xxx", *SCENARIOS]),
    (["--tracker", "missing.csv"], ["missing.csv: ", "No such file"]),
    (["--tracker", "mis\x1b[31msing\n.csv"], ["mis?[31msing?.csv: ", "No such file"]),
    (["--tracker", "folder.csv"], ["folder.csv: ", "directory", "expected a CSV file"]),
    (["--tracker", "/dev/zero"], ["/dev/zero: ", "not a regular file", "expected a CSV file"]),
    (["--tracker", ""], ["--tracker ''", "expected"]),
    (["--tracker", "empty.csv"], ["empty.csv: ", "empty", f"expected the header {HEADER}"]),
    (["--tracker", "header_only.csv"], ["header_only.csv: ", "0, expected at least 2"]),
    (["--tracker", "one_sample.csv"], ["one_sample.csv: ", "1, expected at least 2"]),
    (["--tracker", "words.csv"], ["words.csv:3: x_m is 'left', expected a number"]),
    (["--tracker", "not_a_number.csv"], ["not_a_number.csv:3: x_m is 'nan', expected a number"]),
    (["--tracker", "backwards.csv"], ["backwards.csv:4: t_s is 0.01, expected more than the 0.02"]),
    (["--tracker", "repeated.csv"], ["repeated.csv:4: t_s is 0.01, expected more than the 0.01"]),
    (["--tracker", "few_columns.csv"], ["few_columns.csv:3: ", "7 columns, expected 8"]),
    (["--tracker", "off_unit.csv"], ["off_unit.csv:3: ", "norm", "2, expected 1"]),
    (["--tracker", "wrong_header.csv"], ["wrong_header.csv:1: ", "'time,x,y,z'", f"expected {HEADER}"]),
    (["--tracker", "binary.csv"], ["binary.csv:1: ", "expected"]),
    *((["--tracker", "hand.csv", "--axes", axes], ["axes", f"'{axes}'", "expected", "-yxz"])
      for axes in ("yxz", "xyy", "xy", "xyzx", "abc", "x,y,z")),
    (["--axes", "xyz"], ["--axes 'xyz'", "--tracker"]),
    (["--tracker", "hand.csv", "--axes", ""], ["--axes ''", "expected"]),
    (["--param", "trace=0.5"], ["--param 'trace=0.5'", "a whole number from 0 to 1"]),
    (["--param", "stale_periods=1"], ["--param 'stale_periods=1'", "from 1.5 to 25"]),
    (["--param", "no_such=1"], ["'no_such=1'", "no parameter of this name", "motion_scale", "trace"]),
    *((["--" + name], [f"'--{name}'", "expected a value"]) for name in ("scenario", "tracker", "seed", "gap", "param")),
    *(([f"--{name}", value], [f"--{name} '{value}'", "expected", " from ", " to "])
      for name, out_of_range in NUMBER_OPTIONS.items() for value in (*out_of_range, *NO_NUMBERS)),
    *(([f"--{name}", value], [f"--{name} '{value}'", "expected"]) for name, values in LISTS.items() for value in values),
]  # fmt: skip


def assert_refused(done: Run, words: list[str]) -> None:
    assert done.status == EXIT_WRONG_USE, done.stderr
    assert done.stdout == ""
    assert re.fullmatch(r"comanip-sim: [^\x00-\x1f]+\n", done.stderr), f"not one line: {done.stderr!r}"
    assert len(done.stderr) < 2000
    for word in words:
        assert word in done.stderr


def identity(value: list[str]) -> str:
    return " ".join(value)[:40].encode("unicode_escape").decode()


@pytest.mark.parametrize(("arguments", "words"), WRONG_USE, ids=identity)
def test_wrong_use(workspace, arguments, words):
    before = sorted(workspace.rglob("*"))
    assert_refused(run(workspace / "out", *arguments, cwd=workspace), words)
    assert sorted(workspace.rglob("*")) == before, "something was written"


def test_wrong_use_leaves_former_results_alone(workspace):
    out = workspace / "out"
    out.mkdir()
    for name in FILES:
        (out / name).write_text("former")
    for arguments in (["--rate", "0"], ["--tracker", "words.csv"], ["--param", "no_such=1"], ["juggle"]):
        assert_refused(run(out, *arguments, cwd=workspace), [])
        assert {path.name: path.read_text() for path in out.iterdir()} == dict.fromkeys(FILES, "former")


@pytest.mark.parametrize(
    ("out", "words"),
    [
        ("", ["--out ''", "expected the path of a folder"]),
        ("hand.csv", ["hand.csv: ", "Not a directory"]),
        ("hand.csv/out", ["hand.csv/out: ", "Not a directory"]),
        ("/dev/null", ["/dev/null: ", "Not a directory"]),
        ("/proc", ["/proc/", "cannot be written"]),
        ("/proc/out", ["/proc/out: cannot be created"]),
    ],
)
def test_folder_that_cannot_be_written(workspace, out, words):
    before = sorted(workspace.rglob("*"))
    assert_refused(run(out, "--duration", 2, cwd=workspace), words)
    assert sorted(workspace.rglob("*")) == before


@pytest.mark.parametrize("blocked", [*FILES, *(f"{name}.partial" for name in FILES)])
def test_blocked_file_leaves_former_results_alone(workspace, blocked):
    out = workspace / "out"
    (out / blocked / "inside").mkdir(parents=True)
    others = [name for name in FILES if name != blocked]
    for name in others:
        (out / name).write_text("former")
    before = sorted(out.rglob("*"))
    assert_refused(run(out, "--duration", 2), [f"{out}/{blocked}: cannot be", "Is a directory"])
    assert sorted(out.rglob("*")) == before
    assert all((out / name).read_text() == "former" for name in others)


# ---- help, results, the end of a run


def test_help_lists_all_options_and_its_examples_run(workspace):
    done = call("--help")
    assert done.returncode == EXIT_PASS and done.stderr == ""
    for option in (*NUMBER_OPTIONS, *LISTS, "scenario", "tracker", "axes", "out", "quiet", "list", "help"):
        assert f"--{option}" in done.stdout
    examples = re.findall(r"^  comanip-sim (.*)$", done.stdout.split("\nexamples\n")[1], re.MULTILINE)
    assert len(examples) >= 3
    for i, example in enumerate(examples):
        out = workspace / f"example{i}"
        status = run(out, *shlex.split(example, comments=True), "--out", out, cwd=workspace).status
        assert status in (EXIT_PASS, EXIT_CHECK_FAILED), example
        assert sorted(path.name for path in out.iterdir()) == sorted(FILES)


def test_list_names_the_scenarios():
    done = call("--list")
    assert done.returncode == EXIT_PASS
    assert tuple(line.split()[0] for line in done.stdout.splitlines()) == SCENARIOS


def test_run_without_quiet_ends_with_a_table_and_the_paths(tmp_path):
    out = tmp_path / "new" / "folder"
    done = call("--scenario", "teleop", "--out", out)
    assert done.returncode == EXIT_PASS and done.stderr == ""
    checks = json.loads((out / "summary.json").read_text())["checks"]
    told = re.findall(r"^(\w+) +\S+ [<>]= +\S+ .*(PASS|FAIL)$", done.stdout, re.MULTILINE)
    assert told == [(check["name"], "PASS") for check in checks]
    *paths, last = done.stdout.splitlines()[-4:]
    assert sorted(paths) == sorted(str(out / name) for name in FILES)
    assert last.startswith("teleop: PASS: ")


def test_failed_check_is_said_in_all_places(tmp_path):
    done = run(tmp_path / "out", "--scenario", "teleop", *(f"--param={gain}=1" for gain in GAINS))
    assert done.status == EXIT_CHECK_FAILED
    failed = [check["name"] for check in done.summary["checks"] if not check["pass"]]
    assert "forward" in failed
    assert done.summary["result"] == "fail"
    assert failed[0] in done.summary["reason"]
    assert done.stderr == f"teleop: FAIL: {done.summary['reason']}\n"


def test_run_that_never_starts_fails_and_says_why(tmp_path):
    done = run(tmp_path / "out", "--dropout", 1)
    assert done.status == EXIT_CHECK_FAILED
    assert done.summary["result"] == "fail"
    assert "waiting_for_tracker" in done.summary["reason"]
    assert ("cooperating", "operator_start") not in modes(done)


@pytest.mark.parametrize("signals", [[signal.SIGINT], [signal.SIGINT, signal.SIGINT], [signal.SIGTERM]])
def test_interrupt_ends_the_run_cleanly(tmp_path, signals):
    out = tmp_path / "out"
    process = subprocess.Popen([SIMULATOR, "--duration", "3600", "--quiet", "--out", out])
    try:
        deadline = time.monotonic() + 30
        while not ((out / "bus.log.partial").exists() and (out / "bus.log.partial").stat().st_size > 10**6):
            assert time.monotonic() < deadline and process.poll() is None
            time.sleep(0.01)
        for number in signals:
            process.send_signal(number)
        assert process.wait(timeout=5) == EXIT_INTERRUPTED
    finally:
        process.kill()
        process.wait()
    assert sorted(path.name for path in out.iterdir()) == sorted(FILES), "half-written files are left"
    summary = json.loads((out / "summary.json").read_text())
    assert (summary["result"], summary["reason"]) == ("fail", "interrupted")
    assert (out / "bus.log").read_bytes().count(b"\n") == summary["bus"]["frames"]
    assert (out / "trace.csv").read_bytes().count(b"\n") == summary["ticks"] + 1


# ---- summary.json is a contract

CONTRACT = {
    "scenario": str, "result": str, "reason": str, "seed": int, "sim_s": float, "wall_s": float, "ticks": int,
    "tracking": {"rms_position_mm": float, "max_position_mm": float, "rms_orientation_deg": float,
                 "max_orientation_deg": float},
    "reach": {"out_of_reach_s": float},
    "limits": {"violations": int},
    "bus": {"frames": int, "load_percent_mean": float, "load_percent_peak": float, "dropped": int},
    "tracker": {"samples": int, "lost": int, "longest_gap_ms": float},
    "modes": [{"t_s": float, "mode": str, "reason": str}],
    "checks": [{"name": str, "value": float, "limit": float, "unit": str, "pass": bool}],
}  # fmt: skip


def assert_shape(value: object, shape: object, path: str) -> None:
    if isinstance(shape, dict):
        assert isinstance(value, dict) and list(value) == list(shape), path
        for key, part in shape.items():
            assert_shape(value[key], part, f"{path}.{key}")
    elif isinstance(shape, list):
        assert isinstance(value, list) and value, path
        for item in value:
            assert_shape(item, shape[0], f"{path}[]")
    else:
        accepted = (int, float) if shape is float else shape  # a whole number may be written without a point
        assert isinstance(value, accepted) and isinstance(value, bool) == (shape is bool), f"{path} is {value!r}"


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_summary_has_the_fields_of_the_contract(tmp_path, scenario):
    done = run(tmp_path / "out", "--scenario", scenario, "--seed", 5).require_pass()
    summary = done.summary
    assert_shape(summary, CONTRACT, "summary")
    assert (summary["scenario"], summary["result"], summary["seed"]) == (scenario, "pass", 5)
    assert summary["ticks"] == round(1000 * summary["sim_s"]) == done.trace.read_bytes().count(b"\n") - 1
    assert all(check["pass"] for check in summary["checks"])
    tracking = summary["tracking"]
    assert 0 < tracking["rms_position_mm"] <= tracking["max_position_mm"]
    assert 0 < tracking["rms_orientation_deg"] <= tracking["max_orientation_deg"] <= 180
    assert 0 < summary["bus"]["load_percent_mean"] < summary["bus"]["load_percent_peak"] < 100
    times = [change["t_s"] for change in summary["modes"]]
    assert times == sorted(times)


# ---- options


def poses_of(done: Run) -> tuple[np.ndarray, np.ndarray]:
    """Stamp of each HandPose, and whether it carried a pose."""
    poses = bus_log.read(done.log)["HandPose"]
    return poses.raw("t_us"), poses.raw("valid") == 1


@pytest.mark.parametrize("arguments", [["--dropout", 0.1], ["--gap", "4:0.333"], ["--gap", "5:0.2", "--dropout", 0.03]])
def test_lost_samples_are_those_of_the_bus(tmp_path, arguments):
    done = run(tmp_path / "out", "--scenario", "teleop", *arguments)
    stamp_us, valid = poses_of(done)
    tracker = done.summary["tracker"]
    assert tracker["samples"] == len(stamp_us)
    assert tracker["lost"] == np.sum(~valid) > 0
    assert tracker["longest_gap_ms"] == pytest.approx(1e-3 * np.diff(stamp_us[valid]).max())


def test_gap_is_where_it_was_asked_for(tmp_path):
    done = run(tmp_path / "out", "--scenario", "teleop", "--gap", "4:0.333").require_pass()
    stamp_us, valid = poses_of(done)
    in_gap = (stamp_us >= 4_000_000) & (stamp_us < 4_333_000)
    assert np.array_equal(valid, ~in_gap)
    assert modes(done)[-3:] == [("hold", "tracker_stale"), ("cooperating", "tracker_returned"), ("ready", "operator_stop")]


def test_dropout_is_a_probability(tmp_path):
    """Within five standard deviations, and drawn anew by each seed."""
    drawn = [poses_of(run(tmp_path / str(seed), "--dropout", 0.1, "--seed", seed))[1] for seed in (1, 2)]
    for valid in drawn:
        assert np.mean(~valid) == pytest.approx(0.1, abs=5 * np.sqrt(0.1 * 0.9 / len(valid)))
    assert not np.array_equal(*drawn)


def hand_of(done: Run) -> np.ndarray:
    """ODE's hand, (ticks, 7)."""
    names = done.trace.open().readline().rstrip().split(",")
    columns = [names.index(f"hand_{part}") for part in ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")]
    return np.loadtxt(done.trace, delimiter=",", skiprows=1, usecols=columns)


SILENT = ("--noise-mm", 0, "--noise-deg", 0)
PLACES = [
    ("0.3,1.5,0.2", "0.70710678,0.70710678,0,0", (-np.pi / 2, 0, 0)),  # the default: (9)
    ("-2,0.5,-1", "0.70710678,0.70710678,0,0", (-np.pi / 2, 0, 0)),
    ("1.5,0,0.4", "1,0,0,0", (0, 0, 0)),
    ("2,1,1", f"{np.cos(0.35)},0,0,{np.sin(0.35)}", (0, 0, -0.7)),  # 0.7 rad about z
]


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_motion_does_not_depend_on_where_the_tracker_stands(tmp_path, scenario):
    hands, markers = [], []
    for i, (translation, rotation, tracker_rotation) in enumerate(PLACES):
        turned = [f"--param=tracker_rotation_{axis}_rad={v:.6f}" for axis, v in zip("xyz", tracker_rotation, strict=True)]
        mount = ("--mount-translation", translation, "--mount-rotation", rotation)
        done = run(tmp_path / str(i), "--scenario", scenario, *SILENT, *mount, *turned).require_pass()
        hands.append(hand_of(done))
        w, x, y, z = map(float, rotation.split(","))
        seen_m = bus_log.read(done.log)["HandPose"]
        seen_m = np.stack([seen_m[f"{axis}_m"] for axis in "xyz"], axis=1)
        markers.append(Rotation.from_quat([x, y, z, w]).apply(seen_m) + np.array(translation.split(","), float))
    for marker in markers[1:]:
        assert np.abs(marker - markers[0]).max() < 5e-6, "the trackers do not stand where they should"
    assert np.ptp(hands[0][:, :3], axis=0).max() > 0.02, "the arm has moved"
    for hand in hands[1:]:
        assert np.linalg.norm(hand[:, :3] - hands[0][:, :3], axis=1).max() < 1e-4
        assert np.abs(np.sum(hand[:, 3:] * hands[0][:, 3:], axis=1)).min() > np.cos(0.5 * np.radians(0.1))


def test_latency_delays_the_motion_and_nothing_else(tmp_path):
    early, late = (
        hand_of(run(tmp_path / str(ms), "--scenario", "teleop", *SILENT, "--latency-ms", ms)) for ms in (4, 24)
    )
    moving = slice(1900, 11400)  # after the start command, up to the stop
    shifted = late[20:][moving, :3] - early[:-20][moving, :3]
    assert np.linalg.norm(shifted, axis=1).max() < 1e-4
    assert np.linalg.norm(late[moving, :3] - early[moving, :3], axis=1).max() > 5e-4


def test_options_reach_the_bus(tmp_path):
    done = run(tmp_path / "out", *SILENT, "--rate", 100, "--tracker-clock", 4_294_000_000, "--scale", 0.5, "--duration", 6)
    log = bus_log.read(done.log)
    assert done.summary["sim_s"] == 6
    assert np.all(log["TrackerStatus"]["period_us"] == 10_000)
    stamp_us = log["HandPose"].raw("t_us")
    assert stamp_us[0] == 4_294_000_000
    assert np.all(np.diff(stamp_us) % 2**32 == 10_000) and np.any(np.diff(stamp_us) < 0), "wraps"
    number = {str(name): i for i, name in log["ParameterAccess"].message.get_signal_by_name("parameter").choices.items()}
    assert list(log["ParameterAccess"].raw("parameter")) == [number["motion_scale"]]


def test_axes_turn_the_motion(tmp_path):
    """The recording moves along its x axis: which is torso x, or, with -yxz, torso y."""
    recording = tmp_path / "hand.csv"
    path_m = 0.03 * np.sin(np.linspace(0, np.pi / 2, 200)) ** 2
    recording.write_text(csv(*(f"{0.01 * i:.2f},{x:.6f},0,0,1,0,0,0" for i, x in enumerate(path_m))))
    ways = []
    for axes in ("xyz", "-yxz"):
        done = run(tmp_path / axes, "--scenario", "teleop", *SILENT, "--tracker", recording, "--axes", axes).require_pass()
        hand = hand_of(done)
        ways.append(hand[4200, :3] - hand[600, :3])
    assert ways[0] == pytest.approx([0.03, 0, 0], abs=2e-3)
    assert ways[1] == pytest.approx([0, 0.03, 0], abs=2e-3)


# ---- make


def make(*arguments: str) -> subprocess.CompletedProcess:
    environment = {name: value for name, value in os.environ.items() if name not in ("MAKEFLAGS", "MAKELEVEL", "MFLAGS")}
    return subprocess.run(["make", *arguments], cwd=REPOSITORY, capture_output=True, text=True, check=False, env=environment)


def test_make_alone_prints_help():
    done = make()
    assert done.returncode == 0
    for target in ("sim", "test", "deps", "build", "bench", "target", "clean"):
        assert re.search(rf"^  make {target} ", done.stdout, re.MULTILINE), target


def test_make_sim_passes_everything_on(workspace):
    out = workspace / "a folder"
    recording = workspace / "hand.csv"
    options = "--duration 4 --gap 3:0.1 --param trace=0 --quiet"
    done = make("sim", "SCENARIO=teleop", f"TRACKER={recording}", "SEED=9", f"OUT={out}", f"ARGS={options}")
    assert done.returncode == 0, done.stderr
    summary = json.loads((out / "summary.json").read_text())
    assert (summary["scenario"], summary["seed"], summary["sim_s"]) == ("teleop", 9, 4)
    assert summary["tracker"]["lost"] == 25
    assert make("sim", "SCENARIO=juggle", f"OUT={out}").returncode != 0
