"""Reads the description of an arm, firmware/arms/NAME.toml.

The description uses modified DH parameters. It lists the frames from the torso to the end effector, each of which is
Rot_x(alpha) Trans_x(a) Trans_z(d) Rot_z(theta) relative to the previous one. A frame with a range is a joint, whose
angle is added to theta. Lengths are in m, angles in degrees.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

# The same limits as in arm_check(), firmware/arms/arm.c.
JOINTS_MAX, POSITION_MAX_RAD, VELOCITY_MAX_RADPS, LENGTH_MAX_M = 8, 8.0, 32.0, 100.0
JERK_RADPS3 = (1e3, 1e6)
JERK_DEFAULT_RADPS3 = 1e4
DRIVE_LAG_S = (1e-3, 0.1)
DRIVE_LAG_DEFAULT_S = 0.013
LENGTHS, ANGLES = ("a_m", "d_m"), ("alpha_deg", "theta_deg")
JOINT_KEYS = {"range_deg", "jerk_max_radps3"}
FRAME_KEYS = {*LENGTHS, *ANGLES, *JOINT_KEYS}
OPTIONAL_KEYS = {"margin_deg", "jerk_max_radps3", "drive_lag_max_s"}
ARM_KEYS = {"name", "id", "velocity_max_radps", "frame", *OPTIONAL_KEYS}


class ArmError(ValueError):
    """The description is wrong. The message is one line that states the file, the value and what was expected."""


@dataclass(frozen=True)
class Pose:
    """A pose. rotation: unit quaternion (4,), w first. matrix: the same rotation, (3, 3). translation_m: (3,)."""

    rotation: np.ndarray
    translation_m: np.ndarray

    @property
    def matrix(self) -> np.ndarray:
        w, x, y, z = self.rotation
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        matrix = np.eye(3) + 2 * w * cross + 2 * cross @ cross
        nearest = np.round(matrix)
        return np.where(np.abs(matrix - nearest) < 1e-12, nearest, matrix)

    def __mul__(self, other: Pose) -> Pose:
        return Pose(hamilton(self.rotation, other.rotation), self.translation_m + self.matrix @ other.translation_m)


def hamilton(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.concatenate([[a[0] * b[0] - a[1:] @ b[1:]], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])])


def turn(axis: Sequence[float], angle_deg: float) -> np.ndarray:
    half = np.radians(angle_deg) / 2
    return np.concatenate([[np.cos(half)], np.sin(half) * np.array(axis, float)])


@dataclass(frozen=True)
class Arm:
    """An arm. twist: pose of each joint relative to the moving frame of the previous joint (for the first joint: the
    torso), without the joint's angle offset. effector: pose of the end effector relative to the last joint."""

    name: str
    id: int
    title: str
    twist: list[Pose]
    offset_deg: list[float]
    effector: Pose
    range_rad: list[tuple[float, float]]
    velocity_max_radps: float
    jerk_max_radps3: list[float]
    drive_lag_max_s: float

    @property
    def fixed(self) -> list[Pose]:
        """The twists including the joints' angle offsets: the pose of each joint at angle 0."""
        return [twist * about_z(offset) for twist, offset in zip(self.twist, self.offset_deg, strict=True)]


def about_z(angle_deg: float) -> Pose:
    return Pose(turn([0, 0, 1], angle_deg), np.zeros(3))


def without_theta(alpha_deg: float, a_m: float, d_m: float) -> Pose:
    about_x = Pose(turn([1, 0, 0], alpha_deg), np.zeros(3))
    return about_x * Pose(np.array([1.0, 0, 0, 0]), np.array([a_m, 0.0, d_m]))


def _number(place: str, value: object, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise ArmError(f"{place}: {value!r}: expected a number from {low:g} to {high:g}")
    return float(value)


def _range_rad(place: str, value: object, margin_deg: float) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise ArmError(f"{place}: {value!r}: expected two numbers, the lowest and the highest angle")
    most = math.degrees(POSITION_MAX_RAD)
    low, high = (_number(place, limit, -most - margin_deg, most + margin_deg) for limit in value)
    if not low + margin_deg < high - margin_deg:
        raise ArmError(
            f"{place}: {value!r}: expected the lower limit first, and a range above twice the margin of {margin_deg:g}"
        )
    return math.radians(low + margin_deg), math.radians(high - margin_deg)


def _load(path: Path) -> tuple[dict, str]:
    """Returns the description and the title, which is the file's first line."""
    try:
        text = path.read_text()
        description = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ArmError(f"{path}: {error}") from error
    return description, text.partition("\n")[0].removeprefix("#").strip()


def _check_keys(place: str, found: object, known: set[str]) -> None:
    if not isinstance(found, dict):
        raise ArmError(f"{place}: {found!r}: expected a table")
    if unknown := set(found) - known:
        raise ArmError(f"{place}: {min(unknown)}: unknown, expected {', '.join(sorted(known))}")


def read(path: Path) -> Arm:
    """Reads the description of an arm. Raises ArmError if something is missing, unknown or out of range."""
    description, title = _load(path)
    _check_keys(str(path), description, ARM_KEYS)
    if missing := ARM_KEYS - OPTIONAL_KEYS - set(description):
        raise ArmError(f"{path}: {min(missing)} is missing")
    if description["name"] != path.stem or not path.stem.isidentifier():
        raise ArmError(f"{path}: name: {description['name']!r}: expected the file's name, a C identifier")
    frames = description["frame"]
    if not isinstance(frames, list):
        raise ArmError(f"{path}: frame: {frames!r}: expected a list of tables, [[frame]]")
    margin = _number(f"{path}: margin_deg", description.get("margin_deg", 0.0), 0.0, 90.0)
    jerk = _number(f"{path}: jerk_max_radps3", description.get("jerk_max_radps3", JERK_DEFAULT_RADPS3), *JERK_RADPS3)
    lag = _number(f"{path}: drive_lag_max_s", description.get("drive_lag_max_s", DRIVE_LAG_DEFAULT_S), *DRIVE_LAG_S)
    twists, offsets, ranges, jerks, reached = [], [], [], [], Pose(np.array([1.0, 0, 0, 0]), np.zeros(3))
    for number, frame in enumerate(frames, 1):
        place = f"{path}: frame {number}"
        _check_keys(place, frame, FRAME_KEYS)
        lengths = {key: _number(f"{place}: {key}", frame.get(key, 0.0), -LENGTH_MAX_M, LENGTH_MAX_M) for key in LENGTHS}
        angles = {key: _number(f"{place}: {key}", frame.get(key, 0.0), -360.0, 360.0) for key in ANGLES}
        reached = reached * without_theta(angles["alpha_deg"], **lengths)
        if "range_deg" in frame:
            twists.append(reached)
            offsets.append(angles["theta_deg"])
            ranges.append(_range_rad(f"{place}: range_deg", frame["range_deg"], margin))
            jerks.append(_number(f"{place}: jerk_max_radps3", frame.get("jerk_max_radps3", jerk), *JERK_RADPS3))
            reached = Pose(np.array([1.0, 0, 0, 0]), np.zeros(3))
        else:
            if "jerk_max_radps3" in frame:
                raise ArmError(f"{place}: jerk_max_radps3: expected in joints only (frames with a range_deg)")
            reached = reached * about_z(angles["theta_deg"])
    if not 1 <= len(twists) <= JOINTS_MAX:
        raise ArmError(f"{path}: {len(twists)} joints (frames with a range_deg), expected 1 to {JOINTS_MAX}")
    number = _number(f"{path}: id", description["id"], 0, 255)
    velocity = _number(f"{path}: velocity_max_radps", description["velocity_max_radps"], 1e-3, VELOCITY_MAX_RADPS)
    return Arm(path.stem, int(number), title, twists, offsets, reached, ranges, velocity, jerks, lag)
