"""Tests the simulator's check comes_to_rest: its measured value against numpy on the trace, its failure if the arm
oscillates, how it treats phases in which the hand is not still, and how it reports phases that it cannot measure."""

from __future__ import annotations

import re
from pathlib import Path

import hoap3
import monitor_binding
import numpy as np
import pytest
from simulation import (
    EXIT_CHECK_FAILED,
    EXPERIMENTS,
    REPOSITORY,
    call,
    experiment,
    run,
    shared,
)

ffi, lib = monitor_binding.load()
SHARED = REPOSITORY.parent / "shared"
PARAMETERS = [ffi.string(lib.parameter_table[i].name).decode() for i in range(lib.PARAMETER_COUNT)]
FORMER_LAW = ["--param", "prediction=0"] if "prediction" in PARAMETERS else []
QUIET = ["--noise-mm", 0, "--noise-deg", 0]
START_DEG = [60, -30, -10, -80]

SCENE = """
name: scene
duration_s: 60
arm: {{model: hoap3_right, start_deg: [60, -30, -10, -80]}}
people:
  ann:
    tracked: true
    tremor_mm: {tremor_mm}
    position_m: [0.30, 0.60, 0.05]
    rotation: [{{axis: y, angle_deg: 90}}, {{axis: z, angle_deg: 180}}]
    elbow_m: [0.05, 0.60, -0.05]
    program:
      - {{do: rest, duration_s: 0.5, after: operator.started}}
      - {{do: move, by_m: {by_m}, duration_s: 1.5}}
{steps}
operator:
  - {{do: select, task: {task}}}
  - {{do: start, name: started, at_s: 0.5}}
{operator}
checks: []
"""


def scene(folder: Path, *, by_m="[-0.02, 0.02, 0]", tremor_mm=0.1, steps=("do: rest, duration_s: 3",), task="teleop",
          operator=()) -> Path:  # fmt: skip
    file = folder / "scene.yaml"
    lines = [
        "\n".join(f"{indent}- {{{step}}}" for step in part) for indent, part in (("      ", steps), ("  ", operator))
    ]
    text = SCENE.format(by_m=by_m, tremor_mm=tremor_mm, steps=lines[0], task=task, operator=lines[1])
    file.write_text(text)
    return file


def rest_of(done) -> dict | None:
    return next((check for check in done.summary["checks"] if check["name"] == "comes_to_rest"), None)


def trace_of(done) -> np.ndarray:
    return np.genfromtxt(done.trace, delimiter=",", names=True, dtype=None, encoding=None)


def fastest_radps(trace: np.ndarray) -> np.ndarray:
    return np.nan_to_num(np.abs([trace[f"dq{i}_command_radps"] for i in range(4)])).max(axis=0)


# ---- an oscillating arm


def assert_oscillates(done) -> None:
    """Checks that comes_to_rest fails and that, in the trace, a joint moves fast and reverses more than twice in the
    last second of the cooperation."""
    trace = trace_of(done)
    end = np.flatnonzero(trace["mode"] == "cooperating")[-1]
    last = slice(end - 1000, end)
    turns = max(np.count_nonzero(np.diff(np.sign(trace[f"dq{i}_command_radps"][last]))) for i in range(4))
    assert turns > 2 and fastest_radps(trace)[last].max() > 1
    assert done.status == EXIT_CHECK_FAILED
    rest = rest_of(done)
    assert not rest["pass"]
    assert rest["value"] == pytest.approx(fastest_radps(trace)[end - 999 : end].max(), rel=0.02)
    assert "first: comes_to_rest is " in done.summary["reason"]


def test_a_still_hand_out_of_reach_fails_with_the_former_law(tmp_path):
    """The arm stretches towards a hand that has moved out of reach and stopped, and oscillates forever. The check
    must fail; an earlier version of it passed."""
    file = scene(
        tmp_path,
        by_m="[0.25, 0, 0]",
        tremor_mm=0,
        steps=["do: rest, duration_s: 8"],
        operator=["do: stop, after: ann.done"],
    )
    assert_oscillates(run(tmp_path / "out", "--scenario", file, "--seed", 0, *QUIET, *FORMER_LAW))


def test_the_recorded_fault_fails_with_the_former_law(tmp_path):
    file = SHARED / "tools" / "faults" / "away.yaml"
    if not file.is_file():
        pytest.skip(f"needs {file}")
    done = run(tmp_path / "out", "--scenario", file, "--seed", 0, *FORMER_LAW)
    assert_oscillates(done)
    assert re.search(
        r"target out of reach 9\.\d+ of 10\.\d+ s, followable for 0\.\d+ of 10\.\d+ s", done.summary["reason"]
    )


# ---- measured values


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_each_experiment_ends_at_rest(name):
    """Before the stop, the hand's positions in the trace show that the person's hand is still for 2.5 s, and the
    commands in the trace show that the arm comes to rest."""
    done = shared("--scenario", experiment(name), "--seed", 2).require_pass()
    trace = trace_of(done)
    end = np.flatnonzero(trace["mode"] == "cooperating")[-1]
    still = slice(end - 2500, end)
    hand_m = np.array([trace[f"person_{axis}_m"][still] for axis in "xyz"])
    assert np.ptp(hand_m, axis=1).max() < 2e-3, "the hand moves more than its tremor and the arm's pull explain"
    rest = rest_of(done)
    assert rest["pass"] and done.summary["rest"]["still_s"] >= 2.5 and done.summary["rest"]["not_measured"] is None
    assert rest["value"] == done.summary["rest"]["speed_radps"] >= fastest_radps(trace)[end - 900 : end].max()


def test_without_noise_and_tremor_the_limit_is_as_stated(tmp_path):
    done = run(tmp_path / "out", "--scenario", scene(tmp_path, tremor_mm=0), "--seed", 0, *QUIET).require_pass()
    rest = rest_of(done)
    assert rest["limit"] == 0.02 and rest["unit"] == "rad/s"
    assert 0 <= rest["value"] <= 0.02


@pytest.mark.parametrize(
    ("tremor_mm", "arguments"),
    [(0.1, []), (0, ["--noise-deg", 0]), (0, ["--noise-mm", 0.5]), (0.5, [])],
    ids=["as it comes", "noise", "much noise", "much tremor"],
)
def test_the_limit_is_five_times_the_noise(tmp_path, tremor_mm, arguments):
    """The limit is five times the computed noise, but at least 0.02 rad/s. A limit above 0.02 rad/s must also be 2 to
    15 times the noise of a stable arm, measured as the RMS velocity of the fastest joint while the hand rests at the
    start."""
    file = scene(tmp_path, tremor_mm=tremor_mm, steps=["do: rest, duration_s: 3"])
    file.write_text(file.read_text().replace("do: rest, duration_s: 0.5,", "do: rest, duration_s: 4,"))
    done = run(tmp_path / "out", "--scenario", file, "--seed", 0, *arguments)
    trace = trace_of(done)
    at_start = slice(2000, 4000)
    rms = max(np.sqrt(np.mean(trace[f"dq{i}_command_radps"][at_start] ** 2)) for i in range(4))
    rest = rest_of(done)
    if rest["limit"] > 0.02:
        assert 2 < rest["limit"] / rms < 15, "the limit must be 2 to 15 times the measured noise"
    assert rest["limit"] == pytest.approx(max(0.02, 5 * noise_radps(tremor_mm, arguments)), rel=1e-3)


def noise_radps(tremor_mm: float, arguments: list) -> float:
    """Computes the noise as docs/scenarios.md defines it, with the Jacobian from finite differences and numpy's
    inverse."""
    noise_mm = arguments[arguments.index("--noise-mm") + 1] if "--noise-mm" in arguments else 0.05
    noise_deg = arguments[arguments.index("--noise-deg") + 1] if "--noise-deg" in arguments else 0.02
    q = np.radians(START_DEG)
    shift = 1e-6 * np.eye(4)
    jacobian = np.array([(hoap3.frames(q + d)[-1] - hoap3.frames(q - d)[-1])[:3, 3] / 2e-6 for d in shift]).T
    inverse = jacobian.T @ np.linalg.inv(jacobian @ jacobian.T + 1e-4 * np.eye(3))
    frequency = np.linspace(8, 12, 10001)
    tremor_mps = 1e-3 * tremor_mm / np.sqrt(3) * 2 * np.pi * np.sqrt(np.mean(frequency**2))
    rate_per_s = 35 / 4 if "prediction=0" not in arguments else 35  # prediction reduces sample noise to a quarter
    hand_mps = np.hypot(tremor_mps, rate_per_s * 1e-3 * noise_mm)
    return np.hypot(np.linalg.norm(inverse, axis=1).max() * hand_mps, rate_per_s * np.radians(noise_deg))


def test_the_check_works_without_a_trace(tmp_path):
    done = run(tmp_path / "out", "--scenario", scene(tmp_path), "--param", "trace=0").require_pass()
    assert rest_of(done)["pass"]


# ---- phases that could not be measured


def assert_not_measured(done, complaint: str, *words: str) -> None:
    assert rest_of(done) is None
    assert done.summary["rest"]["not_measured"] is not None
    reason = done.summary["reason"]
    (row,) = (line for line in complaint.splitlines() if line.startswith("comes_to_rest"))
    assert "not measured" in row and "PASS" not in row
    for word in ("comes_to_rest was not measured: ", *words):
        assert word in reason, reason


@pytest.mark.parametrize(
    ("options", "arguments", "words"),
    [
        (
            {"steps": ["do: rest, duration_s: 1.5"]},
            [],
            ["needs 2.5 s: end the program of ann with {do: rest, duration_s: 3}"],
        ),
        ({}, ["--duration", 3], ["beyond the end of the run"]),
        ({}, ["--gap", "3:20"], ["needs 2.5 s"]),
        ({"tremor_mm": 20}, [], ["noise and tremor mask the motion: ", "4.76 rad/s"]),
        ({}, ["--param", "task_blend_s=6"], ["needs 2.5 s"]),
    ],
    ids=["too short", "cut", "in hold", "noise", "task not yet in force"],
)
def test_an_unmeasured_phase_is_reported(tmp_path, options, arguments, words):
    file = scene(tmp_path, **options)
    complaint = call("--scenario", file, "--out", tmp_path / "complaint", "--seed", 0, *arguments).stdout
    done = run(tmp_path / "out", "--scenario", file, "--seed", 0, *arguments)
    assert_not_measured(done, complaint, *words)


# ---- the monitor


class Watch:
    """Feeds the monitor the ticks of a simulated cooperation. By default, the hand is exactly where the person wants it
    (`aim_m`)."""

    def __init__(self):
        self.monitor = ffi.new("rest_monitor_t *")
        lib.rest_monitor_init(self.monitor)
        self.state = ffi.new("physical_state_t *")
        self.state.person_count = 1
        self.now = 0

    def ticks(self, count, *, aim_m=0.0, hand_m=None, turn_rad=0.0, radps=0.0, mode=2, settled_ns=0, holds=False):
        """Feeds `count` ticks. hand_m and radps are numbers, or functions of the tick count since the start."""
        tick, aim = ffi.new("tick_record_t *"), ffi.new("rigid_pose_t *")
        aim.position_m[0], aim.rotation[0] = aim_m, 1
        for _ in range(count):
            tick.time_ns, tick.mode, tick.has_command = 1_000_000 * self.now, mode, True
            tick.command.velocity_radps[self.now % 4] = radps(self.now) if callable(radps) else radps
            hand = aim_m if hand_m is None else hand_m(self.now) if callable(hand_m) else hand_m
            pose = self.state.hand[0]
            pose.position_m[0] = hand
            pose.rotation[0], pose.rotation[3] = np.cos(turn_rad / 2), np.sin(turn_rad / 2)
            self.state.holds[0][0] = holds
            lib.rest_monitor_sample(self.monitor, tick, self.state, aim, settled_ns)
            tick.command.velocity_radps[self.now % 4] = 0
            self.now += 1
        return self

    def end(self):
        lib.rest_monitor_end(self.monitor, 1_000_000 * self.now)
        return self.monitor


def test_a_phase_counts_from_2_5_seconds():
    assert not Watch().ticks(2490).ticks(10, aim_m=0.1).end().measured
    watch = Watch().ticks(2600).ticks(10, aim_m=0.1).end()
    assert watch.measured and watch.longest_s == pytest.approx(2.6, abs=0.1)


@pytest.mark.parametrize(("at", "seen"), [(1500, False), (2500, True), (2995, True), (3005, False)])
def test_only_the_last_second_is_judged(at, seen):
    """A motion of any joint, in either direction, counts only if it occurs in the last second before the next move."""
    for sign in (1, -1):
        watch = (
            Watch().ticks(3000, radps=lambda n: sign * (n == at)).ticks(500, aim_m=0.1, radps=lambda n: n == at).end()
        )
        assert watch.speed_radps_max == float(seen)


def test_the_worst_of_all_phases_counts():
    watch = Watch().ticks(3000, radps=0.3).ticks(3000, aim_m=0.1, radps=0.7).ticks(3000, aim_m=0.2, radps=0.1).end()
    assert watch.speed_radps_max == pytest.approx(0.7)


@pytest.mark.parametrize(
    "change",
    [
        {"mode": 3},
        {"settled_ns": 2_600_000_000},
        {"aim_m": 1e-6},
        {"holds": True},
        {"hand_m": 0.003},
        {"turn_rad": 0.02},
    ],
    ids=["hold", "task", "aim", "grip", "hand", "turn"],
)
def test_any_motion_ends_the_stillness(change):
    still = Watch().ticks(4000).end()
    broken = Watch().ticks(2000).ticks(400, **change).ticks(1600).end()
    assert still.measured and not broken.measured


def test_tremor_counts_as_still_and_a_slow_move_does_not():
    tremor = Watch().ticks(4000, hand_m=lambda n: 5e-4 * np.sin(2 * np.pi * 9.3e-3 * n)).end()
    assert tremor.measured and not tremor.disturbed
    assert not Watch().ticks(4000, hand_m=lambda n: 5e-6 * n).end().measured


def test_a_hand_shaken_by_the_arm_still_counts_as_resting():
    """A resting person holds a pipe together with the arm, and the arm oscillates and shakes the person's hand. If this
    lasts until the end of the phase, the phase is reported as disturbed. If the hand settles before, the rest of the
    phase counts as undisturbed, but here it is too short to be measured."""
    shaken = Watch().ticks(4000, hand_m=lambda n: 0.01 * np.sin(2 * np.pi * 2e-3 * n)).ticks(10, aim_m=0.1).end()
    assert shaken.disturbed and not shaken.measured
    settled = (
        Watch()
        .ticks(4000, hand_m=lambda n: 0.01 * np.sin(2 * np.pi * 2e-3 * n) * (n < 2500))
        .ticks(10, aim_m=0.1)
        .end()
    )
    assert not settled.disturbed and not settled.measured
