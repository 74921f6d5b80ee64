"""Reads a finished run from its folder: summary.json and trace.csv."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

SUMMARY_KEYS = {"scenario": str, "result": str, "seed": int, "modes": list}
JOINTS = 4


class RunDataError(Exception):
    """A file of the run is missing or malformed. The message is one line."""


@dataclass(frozen=True)
class Event:
    t_s: float
    name: str


@dataclass(frozen=True)
class Cup:
    """A cup in the frame of the hand that carries it. mount_m: centre of the inner bottom. axis: unit vector towards
    the opening."""

    carrier: str  # "hand", "person" or "second", as in the trace's columns
    mount_m: tuple[float, float, float]
    axis: tuple[float, float, float]
    radius_m: float
    height_m: float


@dataclass(frozen=True)
class Thing:
    """The object in the trace's object_* columns. For a crank, length_m is the length of the handle and radius_m the
    lever arm."""

    kind: str  # "rod" or "crank"
    length_m: float
    radius_m: float


@dataclass(frozen=True)
class RunData:
    """The data of a run, with one row per tick. An empty cell of the trace is NaN, as are all cells of a column that
    the trace does not have."""

    folder: Path
    summary: dict
    columns: dict[str, np.ndarray]

    @property
    def t_s(self) -> np.ndarray:
        return self.columns["t_s"]

    @property
    def scenario(self) -> str:
        return self.summary["scenario"]

    @property
    def events(self) -> list[Event]:
        """The events, sorted by time."""
        found = [Event(float(event["t_s"]), event["name"]) for event in self.summary.get("events") or []]
        return sorted(found, key=lambda event: event.t_s)

    def event_s(self, *names: str) -> float | None:
        """Returns the time of an event, or None if none of these events occurred. If several of them occurred, the
        first in the order of `names` counts. If that event occurred repeatedly, its first time counts."""
        times = {event.name: event.t_s for event in reversed(self.events)}
        return next((times[name] for name in names if name in times), None)

    def modes(self) -> list[tuple[float, float, str]]:
        """Returns (from, until, mode) for each period of the run with an unchanged mode."""
        changes = self.summary["modes"]
        ends = [change["t_s"] for change in changes[1:]] + [float(self.t_s[-1])]
        return [(change["t_s"], end, change["mode"]) for change, end in zip(changes, ends, strict=True)]

    @property
    def thing(self) -> Thing | None:
        found = self.summary.get("object")
        return Thing(found["kind"], found["length_m"], found["radius_m"]) if found else None

    @property
    def cups(self) -> list[Cup]:
        return [
            Cup(cup["columns"], tuple(cup["mount_m"]), tuple(cup["axis"]), cup["radius_m"], cup["height_m"])
            for cup in self.summary.get("cups") or []
        ]

    def column(self, name: str) -> np.ndarray:
        """Returns a column (N,)."""
        return self.columns.get(name, np.full(len(self.t_s), np.nan))

    def has(self, name: str) -> bool:
        return bool(np.isfinite(self.column(name)).any())

    def limits(self, unit: str) -> list[tuple[str, float]]:
        """Returns the names and limits of the run's checks that have this unit."""
        checks = self.summary.get("checks") or []
        return [(check["name"].replace("_", " "), check["limit"]) for check in checks if check.get("unit") == unit]

    def position_m(self, what: str) -> np.ndarray:
        """Returns the positions (N, 3) of "target", "hand", "person", "second" or "object", in torso axes."""
        return np.stack([self.column(f"{what}_{axis}_m") for axis in "xyz"], axis=1)

    def rotation(self, what: str) -> np.ndarray:
        """Returns the rotations as unit quaternions (N, 4), w first."""
        return np.stack([self.column(f"{what}_q{axis}") for axis in "wxyz"], axis=1)

    def joints_rad(self) -> np.ndarray:
        """Returns the joint positions (N, 4)."""
        return np.stack([self.column(f"q{i}_rad") for i in range(JOINTS)], axis=1)

    def rates_radps(self) -> np.ndarray:
        """Returns the commanded joint velocities (N, 4)."""
        return np.stack([self.column(f"dq{i}_command_radps") for i in range(JOINTS)], axis=1)

    def row_at(self, time_s: float) -> int:
        return int(np.clip(np.searchsorted(self.t_s, time_s), 0, len(self.t_s) - 1))


def read_summary(path: Path) -> dict:
    try:
        summary = json.loads(path.read_text())
    except OSError as error:
        raise RunDataError(f"{path}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise RunDataError(f"{path}: not valid JSON: {error}") from error
    for key, kind in SUMMARY_KEYS.items():
        value = summary.get(key) if isinstance(summary, dict) else None
        if not isinstance(value, kind):
            raise RunDataError(f"{path}: {key} is {value!r}, expected {kind.__name__}")
    return summary


def _with_nan(text: str) -> str:
    """Replaces empty cells with "nan", which numpy's fast reader requires."""
    for _ in range(2):  # twice, because the matches of adjacent empty cells overlap
        text = text.replace(",,", ",nan,")
    return text.replace(",\n", ",nan\n")


def read_trace(path: Path) -> dict[str, np.ndarray]:
    """Returns all columns except `mode` by name, each as (N,) float64."""
    try:
        text = path.read_text()
    except OSError as error:
        raise RunDataError(f"{path}: cannot be read: {error.strerror}") from error
    header, _, body = text.partition("\n")
    names = header.split(",")
    missing = [name for name in ("t_s", "mode", "target_x_m", "hand_x_m", "q0_rad") if name not in names]
    if missing:
        raise RunDataError(f"{path}:1: no column {missing[0]}: not a trace of comanip-sim")
    if not body:
        raise RunDataError(f"{path}: has no rows, expected one per tick")
    if not body.endswith("\n"):
        raise RunDataError(f"{path}:{text.count(chr(10)) + 1}: the last line is incomplete: the run was cut off")
    lines = _with_nan(body).splitlines()
    uneven = next((i for i, line in enumerate(lines) if line.count(",") != len(names) - 1), None)
    if uneven is not None:
        cells = lines[uneven].count(",") + 1
        raise RunDataError(f"{path}:{uneven + 2}: {cells} cells, expected {len(names)}")
    numeric = [i for i, name in enumerate(names) if name != "mode"]
    try:
        table = np.loadtxt(lines, delimiter=",", usecols=numeric, ndmin=2, comments=None)
    except ValueError as error:
        raise RunDataError(f"{path}: not a number (numpy counts rows from line 2): {error}") from error
    return dict(zip([names[i] for i in numeric], table.T.copy(), strict=True))


def read_run(folder: Path) -> RunData:
    if not folder.is_dir():
        raise RunDataError(f"{folder}: there is no such folder")
    return RunData(folder, read_summary(folder / "summary.json"), read_trace(folder / "trace.csv"))
