"""Plays the recording of a hand as the simulator does (docs/recordings.md): a rest, the scaled motion at its recorded
speed, and another rest."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from comanip_dev.following import rotations

HEADER = "t_s,x_m,y_m,z_m,qw,qx,qy,qz"
MAPPINGS = {"xyz": (0, 1, 2), "zxy": (2, 0, 1)}
Y_IS_UP = ("cmu_", "ktk_")
GAP_MEDIANS = 1.5  # intervals longer than this many median intervals are gaps


class RecordingError(Exception):
    """A recording is malformed. The message is one line that states the reason."""


@dataclass(frozen=True)
class Recording:
    """A recorded motion, as displacement and rotation relative to the first sample, in torso axes. t_s: (N,), starts at
    0. displacement_m: (N, 3). turn: quaternions (N, 4), with continuous signs. gap: (N - 1,); gap[i] is true if the
    tracker lost the hand between samples i and i + 1."""

    name: str
    t_s: np.ndarray
    displacement_m: np.ndarray
    turn: np.ndarray
    gap: np.ndarray

    @property
    def duration_s(self) -> float:
        return float(self.t_s[-1])


def read(path: Path) -> Recording:
    with path.open(encoding="utf-8-sig") as file:
        header = file.readline().strip()
        if header != HEADER:
            raise RecordingError(f"{path}:1: header '{header[:60]}': expected '{HEADER}'")
        lines = [line for line in file if line.strip()]
        if not lines:
            raise RecordingError(f"{path}: no samples after the header: expected two or more")
        try:
            rows = np.loadtxt(lines, delimiter=",", ndmin=2)
        except ValueError as error:
            raise RecordingError(f"{path}: {error}") from None
    if len(rows) < 2 or rows.shape[1] != 8 or not np.isfinite(rows).all() or (np.diff(rows[:, 0]) <= 0).any():
        raise RecordingError(f"{path}: expected two or more lines of 8 finite numbers with increasing t_s")
    order = list(MAPPINGS["zxy" if path.name.startswith(Y_IS_UP) else "xyz"])
    position_m = rows[:, 1:4][:, order]
    rotation = rows[:, 4:8] / np.linalg.norm(rows[:, 4:8], axis=1, keepdims=True)
    rotation = rotations.continuous(np.column_stack([rotation[:, 0], rotation[:, 1:][:, order]]))
    interval_s = np.diff(rows[:, 0])
    return Recording(
        name=path.stem,
        t_s=rows[:, 0] - rows[0, 0],
        displacement_m=position_m - position_m[0],
        turn=rotations.multiply(rotation, rotations.conjugate(rotation[0])),
        gap=interval_s > GAP_MEDIANS * np.median(interval_s),
    )


@dataclass(frozen=True)
class HandMotion:
    """The hand's motion in a run from 0 to duration_s. The hand starts to move at begin_s. Without a recording, the
    hand stays at rest."""

    recording: Recording | None
    position_scale: float
    rotation_scale: float
    begin_s: float
    rest_s: float  # duration of the rest after the motion, or after begin_s if there is no recording

    @property
    def end_s(self) -> float:
        return self.begin_s + (self.recording.duration_s if self.recording else 0.0)

    @property
    def duration_s(self) -> float:
        return self.end_s + self.rest_s

    def displacement(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns the displacement in m (N, 3) and the rotation (N, 4) relative to the start pose. Positions are
        interpolated linearly, and rotations along the great circle."""
        if self.recording is None:
            return np.zeros((len(t_s), 3)), np.tile([1.0, 0.0, 0.0, 0.0], (len(t_s), 1))
        r = self.recording
        at_s = np.clip(t_s - self.begin_s, 0.0, r.duration_s)
        before = np.clip(np.searchsorted(r.t_s, at_s, side="right") - 1, 0, len(r.t_s) - 2)
        share = ((at_s - r.t_s[before]) / (r.t_s[before + 1] - r.t_s[before]))[:, None]
        moved_m = r.displacement_m[before] + share * (r.displacement_m[before + 1] - r.displacement_m[before])
        step = rotations.multiply(r.turn[before + 1], rotations.conjugate(r.turn[before]))
        turn = rotations.multiply(rotations.from_vector(share * rotations.to_vector(step)), r.turn[before])
        scaled = rotations.from_vector(self.rotation_scale * rotations.to_vector(turn))
        return self.position_scale * moved_m, scaled

    def visible(self, t_s: np.ndarray) -> np.ndarray:
        """Returns whether the tracker sees the hand at these times (N,); false within gaps."""
        if self.recording is None:
            return np.ones(len(t_s), bool)
        r = self.recording
        at_s = t_s - self.begin_s
        before = np.clip(np.searchsorted(r.t_s, at_s, side="right") - 1, 0, len(r.t_s) - 2)
        inside = (at_s > r.t_s[before]) & (at_s < r.t_s[before + 1])
        return ~(inside & r.gap[before])
