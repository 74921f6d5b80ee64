"""Parses poses of a hand from lines of CSV or JSON, so that any tracker can be connected.

CSV, with values separated by commas, semicolons or blanks, and an optional leading timestamp in seconds:
    x, y, z, qw, qx, qy, qz                  metres and a unit quaternion (order `wxyz`, or `xyzw` as an option)
    3 x 4 or 4 x 4 numbers, row by row       a homogeneous matrix
JSON, one object per line:
    {"t": s, "position": [x, y, z], "quaternion": [w, x, y, z]}    or    {"t": s, "matrix": [[...], ...]}
"""

from __future__ import annotations

import json
import math
import re
from typing import NamedTuple

import numpy as np

ORDERS = ("wxyz", "xyzw")
UNIT_TOLERANCE = 1e-3  # as in the firmware
NO_POSE = re.compile(r"#|(?:t|t_s|time|timestamp|x|x_m)[\s,;]", re.IGNORECASE)  # a comment, or a header line
# For each permitted number of values in a line: whether the first value is a timestamp.
_COUNTS = {7: False, 8: True, 12: False, 13: True, 16: False, 17: True}


class Pose(NamedTuple):
    """A pose of the hand. position_m, quaternion: in the tracker's frame. t_s: timestamp of the line, on the tracker's
    clock."""

    position_m: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]  # w x y z
    t_s: float | None = None


def _quaternion_from_matrix(rotation: np.ndarray) -> np.ndarray:
    """Converts a rotation matrix by Shepperd's method, which computes the quaternion's largest component first."""
    trace = np.trace(rotation)
    greatest = int(np.argmax([trace, *np.diag(rotation)]))
    if greatest == 0:
        w = 0.5 * math.sqrt(1.0 + trace)
        skew = rotation - rotation.T
        return np.array([w, *np.array([skew[2, 1], skew[0, 2], skew[1, 0]]) / (4.0 * w)])
    i = greatest - 1
    j, k = (i + 1) % 3, (i + 2) % 3
    first = 0.5 * math.sqrt(1.0 + rotation[i, i] - rotation[j, j] - rotation[k, k])
    quaternion = np.empty(4)
    quaternion[0] = (rotation[k, j] - rotation[j, k]) / (4.0 * first)
    quaternion[1 + i] = first
    quaternion[1 + j] = (rotation[j, i] + rotation[i, j]) / (4.0 * first)
    quaternion[1 + k] = (rotation[k, i] + rotation[i, k]) / (4.0 * first)
    return quaternion


def _from_quaternion(position: list[float], quaternion: list[float], order: str, t_s: float | None) -> Pose:
    ordered = np.array(quaternion if order == "wxyz" else [quaternion[3], *quaternion[:3]])
    norm = float(np.linalg.norm(ordered))
    if abs(norm - 1.0) > UNIT_TOLERANCE:
        raise ValueError(f"quaternion of norm {norm:.6g}, expected 1 within {UNIT_TOLERANCE:g}")
    return Pose(tuple(position), tuple((ordered / norm).tolist()), t_s)


def _from_matrix(numbers: list[float], t_s: float | None) -> Pose:
    matrix = np.array(numbers).reshape(-1, 4)
    if len(matrix) == 4 and np.abs(matrix[3] - [0, 0, 0, 1]).max() > 1e-6:
        raise ValueError(f"last row {matrix[3].tolist()}, expected 0 0 0 1: are rows and columns exchanged?")
    rotation = matrix[:3, :3]
    error = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if error > UNIT_TOLERANCE:
        raise ValueError(
            f"not a rotation matrix: R R^T is off the identity by {error:.3g}, expected {UNIT_TOLERANCE:g} at most"
        )
    if np.linalg.det(rotation) < 0.0:
        raise ValueError("a reflection, expected a rotation matrix of determinant 1")
    quaternion = _quaternion_from_matrix(rotation)
    return Pose(tuple(matrix[:3, 3].tolist()), tuple((quaternion / np.linalg.norm(quaternion)).tolist()), t_s)


def _numbers(values: object, what: str) -> list[float]:
    flat = np.asarray(values, dtype=object).ravel().tolist()
    for value in flat:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise ValueError(f"{what}: {value!r}, expected finite numbers")
    return [float(value) for value in flat]


def _parse_json(line: str, order: str) -> Pose:
    try:
        content = json.loads(line)
    except json.JSONDecodeError as error:
        raise ValueError(f"not valid JSON ({error.msg} at column {error.colno})") from error
    unknown = set(content) - {"t", "position", "quaternion", "matrix"}
    if unknown:
        raise ValueError(f"unknown '{sorted(unknown)[0]}', expected t, position and quaternion, or matrix")
    t_s = _numbers(content["t"], "t")[0] if content.get("t") is not None else None
    if "matrix" in content:
        numbers = _numbers(content["matrix"], "matrix")
        if len(numbers) not in (12, 16):
            raise ValueError(f"matrix of {len(numbers)} numbers, expected 3 x 4 or 4 x 4")
        return _from_matrix(numbers, t_s)
    for name, count in (("position", 3), ("quaternion", 4)):
        if name not in content:
            raise ValueError(f"'{name}' is missing, expected position and quaternion, or matrix")
        if len(_numbers(content[name], name)) != count:
            raise ValueError(f"{name} of {len(_numbers(content[name], name))} numbers, expected {count}")
    return _from_quaternion(
        _numbers(content["position"], "position"), _numbers(content["quaternion"], "quaternion"), order, t_s
    )


def parse(line: str, order: str = "wxyz") -> Pose | None:
    """Parses a line. Returns None for an empty line, a comment (#) or a header. Raises ValueError for a malformed line,
    with a message that states what is wrong."""
    text = line.strip()
    if not text or NO_POSE.match(text):
        return None
    if text.startswith("{"):
        return _parse_json(text, order)
    numbers = []
    for word in re.split(r"[\s,;]+", text.strip(",; ")):
        try:
            numbers.append(float(word))
        except ValueError:
            raise ValueError(f"'{word[:40]}' is not a number") from None
        if not math.isfinite(numbers[-1]):
            raise ValueError(f"'{word[:40]}' is not finite")
    if len(numbers) not in _COUNTS:
        raise ValueError(
            f"{len(numbers)} numbers, expected 7 (position, quaternion) or 12 or 16 (matrix), "
            "and one more for a leading timestamp"
        )
    t_s = numbers.pop(0) if _COUNTS[len(numbers)] else None
    if len(numbers) == 7:
        return _from_quaternion(numbers[:3], numbers[3:], order, t_s)
    return _from_matrix(numbers, t_s)
