"""Runs the cases in the simulator, with the arm in ODE. The case's lag and dead time are ignored, because the
simulator models the drives' lag (3 ms) and all delays itself."""

from __future__ import annotations

import csv
import subprocess
from pathlib import Path

import numpy as np
from rest_cases import in_torso_axes
from rest_judgement import CREEP_RADPS, WINDOW_S
from rest_loop import COOPERATING, OUTCOME

SCALE = 2.0  # motion_scale: halves the hand's motion; targets move up to 2 m, a scenario's hand at most 1.5 m
BEFORE_S = 0.1  # time from the start of the cooperation until the hand moves
TICK_S = 1e-3
NO_PLACE = -1
SCENARIO = """name: rest
summary: a hand that moves once and then rests
duration_s: {duration_s}
arm: {{model: hoap3_right, start_deg: {start_deg}}}
people:
  person:
    tracked: true
    tremor_mm: 0
    position_m: [0.3, 1.2, 0.3]
    program:
      - {{do: rest, duration_s: {before_s}, after: operator.started}}
      - {{do: move, by_m: {by_m}, turn_deg: {turn_deg}, duration_s: {move_s}}}
      - {{do: rest, duration_s: {rest_s}}}
operator:
  - {{do: select, task: teleop}}
  - {{do: start, name: started, at_s: 0.5}}
  - {{do: stop, after: person.done}}
checks: []
"""


def scenario(case: np.ndarray) -> str:
    """Returns the text of a scenario file with the case's start posture, displacement, turn and durations."""
    move_s, end_s = float(case["move_s"]), float(case["end_s"][-1])
    numbers = {
        "start_deg": np.degrees(case["start_rad"]), "by_m": in_torso_axes(case["way_m"]) / SCALE,
        "turn_deg": np.degrees(in_torso_axes(case["turn_rad"])),
    }  # fmt: skip
    lists = {name: "[" + ", ".join(f"{x:.6f}" for x in values) + "]" for name, values in numbers.items()}
    return SCENARIO.format(
        **lists,
        move_s=f"{move_s:.6f}",
        before_s=BEFORE_S,
        rest_s=f"{end_s - move_s + 0.1:.6f}",
        duration_s=f"{end_s + 3:.3f}",
    )


def run(case: np.ndarray, simulator: Path, folder: Path, parameters: dict[str, float]) -> np.ndarray:
    """Returns the outcome, read from trace.csv. Its `start` is NO_PLACE if the arm would start inside the robot's body.
    Raises RuntimeError if the simulator failed for another reason."""
    file = folder / "rest.yaml"
    file.write_text(scenario(case))
    command = [
        str(simulator),
        "--scenario",
        str(file),
        "--out",
        str(folder),
        "--seed",
        "0",
        "--noise-mm",
        "0",
        "--noise-deg",
        "0",
        "--quiet",
    ]
    written = {"motion_scale": SCALE} | parameters
    command += [word for name, value in written.items() for word in ("--param", f"{name}={value:g}")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if "expected no overlap" in done.stderr:
        one = np.zeros((), OUTCOME)
        one["start"] = NO_PLACE
        return one
    if done.returncode not in (0, 1):
        raise RuntimeError(f"{' '.join(command)}\n{done.stderr}")
    return outcome(case, folder / "trace.csv")


def outcome(case: np.ndarray, trace: Path) -> np.ndarray:
    """Returns an outcome in which only the fields that the judgement and the causes need are set."""
    with trace.open() as stream:
        rows = list(csv.DictReader(stream))
    cooperating = np.array([row["mode"] == "cooperating" for row in rows])
    one = np.zeros((), OUTCOME)
    one["mode"] = COOPERATING
    if not cooperating.any():
        one["interrupted"] = int(WINDOW_S / TICK_S)
        return one
    begin = int(np.argmax(cooperating)) + round(BEFORE_S / TICK_S)
    for window, end_s in enumerate(case["end_s"]):
        end = begin + round(float(end_s) / TICK_S)
        ticks = range(end - round(WINDOW_S / TICK_S), end)
        inside = [rows[i] for i in ticks if i < len(rows) and cooperating[i]]
        one["interrupted"][window] = len(ticks) - len(inside)
        if not inside:
            continue
        for joint in range(4):
            velocity = np.array([float(row[f"dq{joint}_command_radps"] or 0) for row in inside])
            signs = np.sign(velocity[np.abs(velocity) > CREEP_RADPS])
            one["peak_radps"][window, joint] = np.abs(velocity).max()
            one["sign_changes"][window, joint] = np.count_nonzero(np.diff(signs))
            one["position_rad"][window, joint] = float(inside[-1][f"q{joint}_rad"])
            one["velocity_radps"][window, joint] = velocity[-1]
        target = [float(inside[-1][f"target_{name}"]) for name in ("qw", "qx", "qy", "qz", "x_m", "y_m", "z_m")]
        one["target"] = target
    return one
