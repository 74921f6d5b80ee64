"""A run of the simulator as it lies in its folder: summary.json and trace.csv."""

from __future__ import annotations

import io
import json
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

JOINTS = 4
NEEDED = ("t_s", "target_x_m", "target_qw", "hand_x_m", "hand_qw", "q0_rad", "dq0_command_radps")
_MODE_CELL = re.compile(rb"^([^,\n]*),[^,\n]*,", re.MULTILINE)


class RunError(Exception):
    """A run that cannot be read; the text names the file, what it holds and what was expected."""


@dataclass(frozen=True)
class Run:
    """`columns`: trace.csv by name, float64 (ticks,), NaN where a cell is empty; without `mode`, which the summary has."""

    folder: Path
    summary: dict
    columns: dict[str, np.ndarray]

    @property
    def t_s(self) -> np.ndarray:
        return self.columns["t_s"]

    @property
    def scenario(self) -> str:
        return str(self.summary["scenario"])

    def has(self, name: str) -> bool:
        """The column is there, with at least one value."""
        return name in self.columns and bool(np.isfinite(self.columns[name]).any())

    def position_m(self, what: str) -> np.ndarray:
        """(ticks, 3), of `target`, `hand`, `person`, `second` or `object`, in torso axes."""
        return self._stack(f"{what}_{{}}_m", "xyz")

    def rotation(self, what: str) -> np.ndarray:
        """(ticks, 4), quaternions w x y z."""
        return self._stack(f"{what}_q{{}}", "wxyz")

    def joints(self, pattern: str) -> np.ndarray:
        """(ticks, 4), for a pattern such as ``q{}_rad``."""
        return self._stack(pattern, range(JOINTS))

    def events(self) -> list[tuple[float, str]]:
        """(time [s], name), in the order of their times."""
        return sorted((float(event["t_s"]), str(event["name"])) for event in self.summary.get("events") or [])

    def event_s(self, name: str) -> float | None:
        """When it happened first; None: it did not."""
        return next((t_s for t_s, other in self.events() if other == name), None)

    def modes(self) -> list[tuple[float, float, str]]:
        """(from [s], until [s], mode), without changes that change the reason only."""
        result: list[tuple[float, float, str]] = []
        for change in self.summary.get("modes") or []:
            start_s, mode = float(change["t_s"]), str(change["mode"])
            if result and result[-1][2] == mode:
                continue
            if result:
                result[-1] = (result[-1][0], start_s, result[-1][2])
            result.append((start_s, float(self.t_s[-1]), mode))
        return result

    def index_at(self, t_s: float) -> int:
        """Of the tick nearest to this time."""
        after = int(np.clip(np.searchsorted(self.t_s, t_s), 1, len(self.t_s) - 1))
        return after - int(t_s - self.t_s[after - 1] < self.t_s[after] - t_s)

    def _stack(self, pattern: str, keys: str | range) -> np.ndarray:
        return np.stack([self.columns[pattern.format(key)] for key in keys], axis=1)


def read_run(folder: Path) -> Run:
    """RunError: the folder, a file or a column is missing, or a file is broken off."""
    if not folder.is_dir():
        raise RunError(f"{folder}: not a folder, expected one that a run of the simulator has written")
    summary = _read_summary(folder / "summary.json")
    return Run(folder, summary, read_trace(folder / "trace.csv"))


def _read_bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise RunError(f"{path}: {error.strerror}, expected the file that a run of the simulator writes") from None


def _read_summary(path: Path) -> dict:
    try:
        summary = json.loads(_read_bytes(path))
    except ValueError as error:
        raise RunError(f"{path}: no complete JSON ({error}): did the run end?") from None
    if not isinstance(summary, dict) or "scenario" not in summary:
        raise RunError(f"{path}: no key 'scenario', expected a summary of the simulator")
    return summary


def read_trace(path: Path) -> dict[str, np.ndarray]:
    """The columns of a trace.csv but `mode`, each float64 (ticks,). RunError: missing, or broken off."""
    head, _, body = _read_bytes(path).partition(b"\n")
    names = head.decode("utf-8", "replace").split(",")
    missing = [name for name in NEEDED if name not in names]
    if missing or names[1] != "mode":
        raise RunError(f"{path}:1: no column '{(missing or ['mode'])[0]}', expected a trace of the simulator")
    table = _numbers(path, _MODE_CELL.sub(rb"\1,", body), len(names) - 1)
    if len(table) < 2:
        raise RunError(f"{path}: {len(table)} ticks, expected at least 2: did the run end?")
    return dict(zip([names[0], *names[2:]], np.ascontiguousarray(table.T), strict=True))


def _numbers(path: Path, body: bytes, columns: int) -> np.ndarray:
    if not body.endswith(b"\n"):
        line = body.count(b"\n") + 2
        raise RunError(f"{path}:{line}: the line is broken off, expected {columns + 1} cells: did the run end?")
    for _ in range(2):  # an empty cell may have an empty one beside it
        body = body.replace(b",,", b",nan,")
    body = body.replace(b",\n", b",nan\n")
    try:
        table = np.loadtxt(io.BytesIO(body), delimiter=",", ndmin=2)
    except ValueError as error:
        raise RunError(f"{path}: {str(error).rstrip('.')} (lines counted from the second)") from None
    if table.size and table.shape[1] != columns:
        raise RunError(f"{path}: {table.shape[1] + 1} cells in a line, expected {columns + 1} as in the first one")
    return table
