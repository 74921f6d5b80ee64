"""Checks the simulator's command line. On invalid arguments, the simulator prints one clear line and does nothing else.
The help is correct. A run that fails or is interrupted reports this in its exit status and its files."""

from __future__ import annotations

import json
import re
import shlex
import signal
import subprocess
import time
from pathlib import Path

import pytest
from simulation import (
    EXIT_CHECK_FAILED,
    EXIT_INTERRUPTED,
    EXIT_PASS,
    EXIT_WRONG_USE,
    FILES,
    PATIENCE_S,
    RECORDING_HEADER,
    SCENARIOS,
    SHIPPED,
    SHORT,
    SIMULATOR,
    Run,
    call,
    modes,
    recording_csv,
    run,
)

GAINS = [f"gain_{part}{axis}_per_s" for part in ("", "dual_") for axis in "wxyz"]

RECORDINGS = {
    "empty.csv": "",
    "header_only.csv": recording_csv(),
    "one_sample.csv": recording_csv("0,0,0,0,1,0,0,0"),
    "words.csv": recording_csv("0,0,0,0,1,0,0,0", "0.01,left,0,0,1,0,0,0"),
    "not_a_number.csv": recording_csv("0,0,0,0,1,0,0,0", "0.01,nan,0,0,1,0,0,0"),
    "backwards.csv": recording_csv("0,0,0,0,1,0,0,0", "0.02,0,0,0,1,0,0,0", "0.01,0,0,0,1,0,0,0"),
    "repeated.csv": recording_csv("0,0,0,0,1,0,0,0", "0.01,0,0,0,1,0,0,0", "0.01,0,0,0,1,0,0,0"),
    "few_columns.csv": recording_csv("0,0,0,0,1,0,0,0", "0.01,0,0,0,1,0,0"),
    "off_unit.csv": recording_csv("0,0,0,0,1,0,0,0", "0.01,0,0,0,2,0,0,0"),
    "wrong_header.csv": "time,x,y,z\n0,0,0,0\n",
    "hand.csv": recording_csv(*(f"{0.01 * i:.2f},{0.0001 * i:.4f},0,0,1,0,0,0" for i in range(100))),
}


@pytest.fixture
def workspace(tmp_path):
    """Creates a folder with recordings, most of them invalid, and other kinds of files."""
    for name, text in RECORDINGS.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "binary.csv").write_bytes(bytes(range(256)))
    (tmp_path / "folder.csv").mkdir()
    return tmp_path


# ---- usage errors

NUMBER_OPTIONS = {
    "duration": ("1.9", "86401"),
    "rate": ("14", "1001"),
    "noise-mm": ("-0.1", "1001"),
    "noise-deg": ("-0.1", "58"),
    "latency-ms": ("-1", "501"),
    "dropout": ("-0.01", "1.01"),
    "scale": ("0", "11"),
    "clutch": ("0.9", "86401"),
    "seed": ("-1", "18446744073709551616"),
    "tracker-clock": ("-1", "4294967296"),
}
NO_NUMBERS = ("nan", "inf", "-inf", "1e999", "1e308", "abc", "", "0x10", "5 ", "1,2")
LISTS = {
    "gap": ("5", "5:", ":1", "-1:1", "1:-1", "nan:1", "1:inf", "1:2:3", "1e308:1", "a:b", ""),
    "mount-translation": ("1", "1,2", "1,2,3,4", "nan,0,0", "1001,0,0", "0,0,-1e308", "a,b,c", ""),
    "mount-rotation": ("1", "0,0,0,0", "1,1,0,0", "nan,0,0,0", "1,0,0", "2,0,0,0", ""),
    "define": ("", "constant", "round:0,0,0:1,0,0,0:1,0,0,0:1", "constant:0,0,9:1,0,0,0:1,0,0,0:1",
               "constant:0,0,0:1,1,0,0:1,0,0,0:1", "mirrored:0,0,0:1,0,0,0:0,0,0,0:1",
               "constant:0,0,0:1,0,0,0:1,0,0,0:66", "constant:0,nan,0:1,0,0,0:1,0,0,0:1",
               "constant:0,0,0:1,0,0,0:1,0,0,0", 300 * "constant:"),
    "param": ("motion_scale", "=1", "no_such=1", "motion_scale=", "motion_scale=nan", "motion_scale=-1"),
}  # fmt: skip
# Invalid arguments, and what the error line must contain: the option or file, the value and what was expected.
WRONG_USE = [
    (["juggle"], ["'juggle'", "expected options"]),
    (["--", "pour"], ["'pour'", "expected options"]),
    (["--fast"], ["'--fast'", "no such option", "--help"]),
    (["-x"], ["'-x'", "no such option", "--help"]),
    (["-xy"], ["'-x'", "no such option", "--help"]),
    (["--help=5"], ["'--help=5'", "takes no value"]),
    (["--scenario", "juggle"], ["--scenario 'juggle'", *SCENARIOS]),
    (["--scenario", ""], ["--scenario ''", "scenario's name", "path of its file"]),
    (["--scenario", "po\nur"], ["--scenario 'po?ur'", *SCENARIOS]),
    (["--scenario", 5000 * "x"], ["--scenario 'xxx", *SCENARIOS]),
    (["--tracker", "missing.csv"], ["missing.csv: ", "No such file"]),
    (["--tracker", "mis\x1b[31msing\n.csv"], ["mis?[31msing?.csv: ", "No such file"]),
    (["--tracker", "folder.csv"], ["folder.csv: ", "directory", "expected a CSV file"]),
    (["--tracker", "/dev/zero"], ["/dev/zero: ", "not a regular file", "expected a CSV file"]),
    (["--tracker", ""], ["--tracker ''", "expected"]),
    (["--tracker", "empty.csv"], ["empty.csv: ", "empty", f"expected the header {RECORDING_HEADER}"]),
    (["--tracker", "header_only.csv"], ["header_only.csv: ", "0, expected at least 2"]),
    (["--tracker", "one_sample.csv"], ["one_sample.csv: ", "1, expected at least 2"]),
    (["--tracker", "words.csv"], ["words.csv:3: x_m is 'left', expected a number"]),
    (["--tracker", "not_a_number.csv"], ["not_a_number.csv:3: x_m is 'nan', expected a number"]),
    (["--tracker", "backwards.csv"], ["backwards.csv:4: t_s is 0.01, expected more than the 0.02"]),
    (["--tracker", "repeated.csv"], ["repeated.csv:4: t_s is 0.01, expected more than the 0.01"]),
    (["--tracker", "few_columns.csv"], ["few_columns.csv:3: ", "has 7 columns, expected 8"]),
    (["--tracker", "off_unit.csv"], ["off_unit.csv:3: ", "norm", "2, expected 1"]),
    (["--tracker", "wrong_header.csv"], ["wrong_header.csv:1: ", "'time,x,y,z'", f"expected {RECORDING_HEADER}"]),
    (["--tracker", "binary.csv"], ["binary.csv:1: ", "expected"]),
    *((["--tracker", "hand.csv", "--axes", axes], ["axes", f"'{axes}'", "expected", "-yxz"])
      for axes in ("yxz", "xyy", "xy", "xyzx", "abc", "x,y,z")),
    (["--clutch", "100"], ["--clutch '100'", "less than 89.5 s"]),
    (["--axes", "xyz"], ["--axes 'xyz'", "--tracker"]),
    (["--tracker", "hand.csv", "--axes", ""], ["--axes ''", "expected"]),
    (["--param", "trace=0.5"], ["--param 'trace=0.5'", "a whole number from 0 to 1"]),
    (["--param", "stale_periods=1"], ["--param 'stale_periods=1'", "from 1.5 to 25"]),
    (["--param", "no_such=1"], ["'no_such=1'", "no parameter of this name", "motion_scale", "trace"]),
    *((["--" + name], [f"'--{name}'", "expected a value"]) for name in ("scenario", "tracker", "seed", "gap", "param")),
    *(([f"--{name}", value], [f"--{name} '{value}'", "expected", " from ", " to "])
      for name, out_of_range in NUMBER_OPTIONS.items() for value in (*out_of_range, *NO_NUMBERS)),
    *(([f"--{name}", value], [f"--{name} '{value[:200]}'", "expected"])
      for name, values in LISTS.items() for value in values),
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


def test_wrong_use_keeps_earlier_results(workspace):
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
def test_blocked_file_keeps_earlier_results(workspace, blocked):
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
    assert call("-h").stdout == done.stdout
    others = ("scenario", "tracker", "axes", "paper-law", "out", "quiet", "list", "help")
    for option in (*NUMBER_OPTIONS, *LISTS, *others):
        assert f"--{option}" in done.stdout
    examples = re.findall(r"^  \S*comanip-sim (.*)$", done.stdout.split("\nexamples\n")[1], re.MULTILINE)
    assert len(examples) >= 3
    for i, example in enumerate(examples):
        out = workspace / f"example{i}"
        status = run(out, *shlex.split(example, comments=True), "--out", out, cwd=workspace).status
        assert status in (EXIT_PASS, EXIT_CHECK_FAILED), example
        assert sorted(path.name for path in out.iterdir()) == sorted(FILES)


def test_list_names_the_scenarios():
    done = call("--list")
    assert done.returncode == EXIT_PASS
    assert tuple(line.split()[0] for line in done.stdout.splitlines()) == SHIPPED


def test_run_without_quiet_ends_with_a_table_and_the_paths(tmp_path):
    out = tmp_path / "new" / "folder"
    done = call("--scenario", "teleop", "--out", out)
    assert done.returncode == EXIT_PASS and done.stderr == ""
    checks = json.loads((out / "summary.json").read_text())["checks"]
    rows = re.findall(r"^(\w+) +\S+ [<>]= +\S+ .*(PASS|FAIL)$", done.stdout, re.MULTILINE)
    assert rows == [(check["name"], "PASS") for check in checks]
    *paths, last = done.stdout.splitlines()[-4:]
    assert sorted(paths) == sorted(str(out / name) for name in FILES)
    assert last.startswith("teleop: PASS: ")


def test_failed_check_is_reported_everywhere(tmp_path):
    done = run(
        tmp_path / "out", "--scenario", "teleop", "--param=prediction=0", *(f"--param={gain}=1" for gain in GAINS)
    )
    assert done.status == EXIT_CHECK_FAILED
    failed = [check["name"] for check in done.summary["checks"] if not check["pass"]]
    assert "forward" in failed
    assert done.summary["result"] == "fail"
    assert failed[0] in done.summary["reason"]
    assert done.stderr == f"teleop: FAIL: {done.summary['reason']}\n"


def test_run_that_never_starts_fails_with_a_reason(tmp_path):
    done = run(tmp_path / "out", "--dropout", 1)
    assert done.status == EXIT_CHECK_FAILED
    assert done.summary["result"] == "fail"
    assert "waiting_for_tracker" in done.summary["reason"]
    assert ("cooperating", "operator_start") not in modes(done)


def test_two_runs_do_not_share_a_folder(tmp_path):
    out = tmp_path / "out"
    first = subprocess.Popen([SIMULATOR, "--duration", "3600", "--quiet", "--out", out])
    try:
        wait_until_running(first, out)
        assert_refused(run(out), [f"{out}: is in use by another run"])
        first.send_signal(signal.SIGINT)
        assert first.wait(PATIENCE_S) == EXIT_INTERRUPTED
    finally:
        first.kill()
        first.wait()
    assert sorted(path.name for path in out.iterdir()) == sorted(FILES), "the second run removed the first one's files"
    run(out, *SHORT).require_pass()


def wait_until_running(process: subprocess.Popen, out: Path) -> None:
    log = out / "bus.log.partial"
    deadline = time.monotonic() + PATIENCE_S
    while not (log.exists() and log.stat().st_size > 10**6):
        assert time.monotonic() < deadline and process.poll() is None
        time.sleep(0.01)


@pytest.mark.parametrize("signals", [[signal.SIGINT], [signal.SIGINT, signal.SIGINT], [signal.SIGTERM]])
def test_interrupt_ends_the_run_cleanly(tmp_path, signals):
    out = tmp_path / "out"
    process = subprocess.Popen([SIMULATOR, "--duration", "3600", "--quiet", "--out", out])
    try:
        wait_until_running(process, out)
        for number in signals:
            process.send_signal(number)
        assert process.wait(PATIENCE_S) == EXIT_INTERRUPTED
    finally:
        process.kill()
        process.wait()
    assert sorted(path.name for path in out.iterdir()) == sorted(FILES), "half-written files are left"
    summary = json.loads((out / "summary.json").read_text())
    assert (summary["result"], summary["reason"]) == ("fail", "interrupted")
    assert (out / "bus.log").read_bytes().count(b"\n") == summary["bus"]["frames"]
    assert (out / "trace.csv").read_bytes().count(b"\n") == summary["ticks"] + 1
