"""Estimates the rotation between tracker and robot, q_Tv^E, from three guided moves of the hand.

The person moves the hand forward, to the left and up, along the x, y and z axes of the robot's torso, with rests
between the moves. The tracker measures the three directions. Finding the rotation that best maps the torso's axes to
these directions in the least-squares sense is Wahba's problem, which a singular value decomposition solves (Kabsch;
Markley 1988). The uncertainty is computed from the residuals of the directions. The covariance of the rotation is the
variance of the residuals times the inverse of the Fisher information matrix for unit variance.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from comanip.errors import ToolError

MOVES = ("forward", "left", "up")
REST_SPEED_MPS = 0.04
REST_S = 0.4
LEAST_MOVE_M = 0.12
MOST_CROOKED = 0.15  # RMS distance from the straight line, divided by the move's length
MOST_UNSURE_DEG = 5.0  # standard error of the rotation
SPEED_WINDOW_S = 0.1
PARAMETERS = tuple(f"tracker_rotation_{axis}_rad" for axis in "xyz")
DEGREES_OF_FREEDOM = 2 * len(MOVES) - 3  # two angles for each direction, minus three angles for the rotation


class CalibrationError(ToolError):
    """The moves do not determine the rotation. The message states the reason."""


@dataclass(frozen=True)
class Move:
    """A straight move between two rests. direction: unit vector in the tracker's frame. crooked: RMS distance from the
    straight line, divided by the length."""

    direction: np.ndarray
    length_m: float
    crooked: float


@dataclass
class MoveDetector:
    """Detects the moves between rests in a sequence of positions. A move back to the start also counts as a move."""

    _times: list[float] = field(default_factory=list)
    _points: list[np.ndarray] = field(default_factory=list)
    _rest_since: float | None = None
    _rest_point: np.ndarray | None = None

    @property
    def is_resting(self) -> bool:
        return self._rest_point is not None

    def feed(self, t_s: float, position_m: np.ndarray) -> Move | None:
        """Processes a position. Once the hand has rested for REST_S, returns the move that led to this rest, if any.
        Otherwise returns None."""
        if self._times and t_s <= self._times[-1]:
            return None
        self._times.append(t_s)
        self._points.append(np.asarray(position_m, float))
        first = np.searchsorted(self._times, t_s - SPEED_WINDOW_S)
        if first == len(self._times) - 1 or t_s - self._times[0] < SPEED_WINDOW_S:
            return None
        speed = np.linalg.norm(self._points[-1] - self._points[first]) / (t_s - self._times[first])
        if speed > REST_SPEED_MPS:
            self._rest_since = None
            return None
        self._rest_since = t_s if self._rest_since is None else self._rest_since
        if t_s - self._rest_since < REST_S:
            return None
        return self._rest_reached()

    def _rest_reached(self) -> Move | None:
        start = int(np.searchsorted(self._times, self._rest_since))
        here = np.mean(self._points[start:], axis=0)
        before, self._rest_point = self._rest_point, here
        path = np.array(self._points[: start + 1])
        self._times, self._points = self._times[start:], self._points[start:]
        self._rest_since = self._times[0]
        if before is None or np.linalg.norm(here - before) < LEAST_MOVE_M:
            # The previous rest is kept, so that a slow drift adds up to a move.
            self._rest_point = here if before is None else before
            return None
        return _move(before, here, path)


def _move(start: np.ndarray, end: np.ndarray, path: np.ndarray) -> Move:
    span = end - start
    length = float(np.linalg.norm(span))
    direction = span / length
    aside = (path - start) - np.outer((path - start) @ direction, direction)
    crooked = float(np.sqrt((aside**2).sum(axis=1).mean())) / length
    return Move(direction, length, crooked)


@dataclass(frozen=True)
class Calibration:
    """The result of a calibration. rotation: matrix that maps torso axes to the tracker's frame. standard_error_deg:
    standard error of the rotation about its most uncertain axis."""

    rotation: np.ndarray  # (3, 3)
    residual_deg: tuple[float, float, float]
    standard_error_deg: float

    @property
    def rotation_vector(self) -> np.ndarray:
        """The values of the three parameters: (3,) in rad, with a norm of at most pi."""
        return rotation_vector(self.rotation)


def rotation_vector(rotation: np.ndarray) -> np.ndarray:
    """Returns the rotation vector (axis times angle) of a rotation matrix."""
    symmetric = (rotation + rotation.T) / 2
    skew = 0.5 * np.array(
        [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]
    )
    sine, cosine = np.linalg.norm(skew), (np.trace(rotation) - 1.0) / 2.0
    angle = float(np.arctan2(sine, cosine))
    if sine > 1e-3 or cosine > 0.0:
        return skew * (angle / sine) if sine > 1e-12 else skew
    # Near half a turn the symmetric part determines the axis a: R + R^T = 2 cos I + 2 (1 - cos) a a^T.
    axis = np.linalg.eigh(symmetric)[1][:, -1]
    axis = axis if axis @ skew >= 0.0 else -axis
    return axis * angle


def rotation_from_vector(vector: np.ndarray) -> np.ndarray:
    """Returns the rotation matrix of a rotation vector, by Rodrigues' formula."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = np.asarray(vector) / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def solve(moves: Iterable[Move]) -> Calibration:
    """Estimates the rotation from the moves forward, left and up. Raises CalibrationError if the moves do not
    determine the rotation accurately enough."""
    moves = list(moves)
    if len(moves) != len(MOVES):
        raise CalibrationError(
            f"{len(moves)} moves found, expected {len(MOVES)} with rests between: {', '.join(MOVES)}"
        )
    for name, move in zip(MOVES, moves):
        if move.crooked > MOST_CROOKED:
            raise CalibrationError(
                f"the move {name} is crooked: {100 * move.crooked:.0f} % of its length off the line, "
                f"expected {100 * MOST_CROOKED:.0f} % at most"
            )
    directions = np.array([move.direction for move in moves])  # rows: images of x, y, z
    if np.linalg.det(directions) < 0.0:
        raise CalibrationError(
            "the moves form a left-handed frame, expected a right-handed one: "
            "was a move in the opposite direction (back, right or down)?"
        )
    u, _, vt = np.linalg.svd(directions.T)
    rotation = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    cosines = np.clip((directions * rotation.T).sum(axis=1), -1.0, 1.0)
    residual = np.arccos(cosines)
    variance = float((residual**2).sum()) / DEGREES_OF_FREEDOM
    information = sum(np.eye(3) - np.outer(d, d) for d in directions)
    standard_error = float(np.degrees(np.sqrt(variance * np.linalg.eigvalsh(np.linalg.inv(information)).max())))
    result = Calibration(rotation, tuple(np.degrees(residual).tolist()), standard_error)
    if standard_error > MOST_UNSURE_DEG:
        off = ", ".join(f"{name} {angle:.0f}" for name, angle in zip(MOVES, result.residual_deg))
        raise CalibrationError(
            f"too uncertain: standard error {standard_error:.1f} degrees, expected {MOST_UNSURE_DEG:g} at most; "
            f"the moves are not at right angles (degrees off: {off})"
        )
    return result
