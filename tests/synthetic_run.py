"""Writes trace.csv and summary.json of a synthetic run. The motions are minimum-jerk (Flash and Hogan, J. Neuroscience
1985), so that the expected values can be computed in closed form."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

POSE = ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")
COLUMNS = (
    *("t_s", "mode"),
    *(f"target_{name}" for name in POSE),
    *(f"hand_{name}" for name in POSE),
    *(f"q{i}_rad" for i in range(4)),
    *(f"dq{i}_command_radps" for i in range(4)),
    *(f"{who}_{name}" for who in ("person", "second", "object") for name in POSE),
    *("gripper_opening", "force_x_N", "force_y_N", "force_z_N", "second_force_N"),
    *("clearance_person_mm", "clearance_self_mm", "water_robot", "water_person", "water_spilt", "crank_turns"),
)
FACE_TO_FACE = np.array([np.sqrt(0.5), 0.0, -np.sqrt(0.5), 0.0])
TICK_S = 0.01  # coarser than the simulator's, so that plots are drawn faster
START_RAD = np.radians([90.0, -5.0, 0.0, -90.0])
EVENTS = {
    "pour": ("operator.pouring", "person.at_spot_2", "person.at_spot_3", "person.at_spot_4"),
    "teleop": ("operator.started", "robot.holds", "taker.holds", "taker.away"),
    "mirror": ("operator.started", "person.back", "operator.latched", "person.carried"),
    "handover": ("operator.started", "person.reaching", "person.holds", "person.away"),
    "crank": ("operator.started", "person.holds", "person.turned"),
}


def minimum_jerk(t_s: np.ndarray, start_s: float, duration_s: float) -> np.ndarray:
    """Returns the minimum-jerk profile, which rises from 0 to 1."""
    s = np.clip((t_s - start_s) / duration_s, 0.0, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


def columns(scenario: str, duration_s: float = 8.0, tick_s: float = TICK_S) -> dict[str, np.ndarray | list[str]]:
    """Returns the columns of the trace. There is no target until 0.5 s. The hand moves 30 mm along x from 1 s to 3 s
    and is always 2 mm behind its target."""
    t = np.round(np.arange(round(duration_s / tick_s)) * tick_s, 3)
    empty = np.full(len(t), np.nan)
    value: dict[str, np.ndarray | list[str]] = {name: empty.copy() for name in COLUMNS}
    value["t_s"] = t
    value["mode"] = ["ready" if s < 0.5 else "cooperating" for s in t]
    way = 0.03 * minimum_jerk(t, 1.0, 2.0)
    target = {"x_m": 0.138 + way, "y_m": -0.111 + 0.0 * t, "z_m": 0.014 + 0.0 * t}
    hand = {**target, "x_m": 0.136 + way}
    person = {"x_m": 0.40 - way, "y_m": -0.12 + 0.01 * np.sin(t), "z_m": 0.014 + 0.0 * t}
    for who, place in (("target", target), ("hand", hand), ("person", person), ("object", hand)):
        for name, numbers in place.items():
            value[f"{who}_{name}"] = numbers
        for name, number in zip(POSE[3:], FACE_TO_FACE, strict=True):
            value[f"{who}_{name}"] = np.full(len(t), number)
    for name in POSE:
        value[f"target_{name}"] = np.where(t < 0.5, np.nan, value[f"target_{name}"])
    for i, angle in enumerate(START_RAD):
        value[f"q{i}_rad"] = np.full(len(t), angle)
        value[f"dq{i}_command_radps"] = np.where(t < 0.001, np.nan, 0.0)
    value["clearance_person_mm"], value["clearance_self_mm"] = 80.0 - 1e3 * way, np.full(len(t), 25.0)
    if scenario == "pour":
        poured = np.round(40 * minimum_jerk(t, 2.0, 4.0))
        value["water_robot"], value["water_person"], value["water_spilt"] = 76 - poured, poured, 0.0 * t
    else:
        value["force_x_N"] = np.where(t < 4.0, np.nan, 3.0)
        value["force_y_N"] = np.where(t < 4.0, np.nan, 4.0)
        value["force_z_N"] = np.where(t < 4.0, np.nan, 0.0)
    if scenario == "teleop":
        for name in POSE:
            value[f"second_{name}"] = value[f"person_{name}"]
    if scenario == "crank":
        value["crank_turns"] = 3.02 * minimum_jerk(t, 2.0, 5.0)
    return value


def cell(value: object) -> str:
    if isinstance(value, str):
        return value
    return "" if np.isnan(value) else f"{value:.7g}"


def trace_text(value: dict) -> str:
    rows = zip(*(value[name] for name in COLUMNS), strict=True)
    return "\n".join([",".join(COLUMNS), *(",".join(map(cell, row)) for row in rows)]) + "\n"


def summary(scenario: str, seed: int = 1, **changes: object) -> dict:
    times = np.linspace(1.0, 7.0, len(EVENTS.get(scenario, ()))) if scenario in EVENTS else []
    return {
        "scenario": scenario,
        "result": "pass",
        "reason": "all checks passed",
        "seed": seed,
        "tracking": {"rms_position_mm": 2.0, "rms_orientation_deg": 0.0},
        "modes": [
            {"t_s": 0.0, "mode": "ready", "reason": "inputs_ready"},
            {"t_s": 0.5, "mode": "cooperating", "reason": "operator_start"},
        ],
        "checks": [],
        "people": [{"name": "person", "force_rms_N": 5.0, "force_peak_N": 5.0}],
        "events": [{"t_s": float(t), "name": name} for t, name in zip(times, EVENTS.get(scenario, ()), strict=True)],
        **changes,
    }


def write(folder: Path, scenario: str, duration_s: float = 8.0, **changes: object) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "summary.json").write_text(json.dumps(summary(scenario, **changes)))
    (folder / "trace.csv").write_text(trace_text(columns(scenario, duration_s)))
    return folder
