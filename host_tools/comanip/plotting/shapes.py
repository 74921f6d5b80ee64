"""Sizes of what is handled, from the scenario's file: the trace has poses only."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from comanip.plotting.geometry import rotation_matrices

SCENARIOS = Path(__file__).resolve().parents[3] / "sim" / "scenarios"
RIM_POINTS = 25


@dataclass(frozen=True)
class Cup:
    """Open at +z of its frame, whose origin is the centre of the bottom; the mount is seen from the hand."""

    radius_m: float
    height_m: float
    mount_m: np.ndarray
    mount_rotation: np.ndarray

    def outline_m(self, hand_m: np.ndarray, hand_rotation: np.ndarray) -> list[np.ndarray]:
        """Lines to draw, each (n, 3) in torso axes: bottom, rim and four edges."""
        angle = np.linspace(0, 2 * np.pi, RIM_POINTS)
        circle = np.stack([self.radius_m * np.cos(angle), self.radius_m * np.sin(angle), 0 * angle], axis=1)
        rim = circle + [0, 0, self.height_m]
        edges = [np.array([circle[i], rim[i]]) for i in range(0, RIM_POINTS - 1, (RIM_POINTS - 1) // 4)]
        rotation = hand_rotation @ self.mount_rotation
        origin = hand_m + hand_rotation @ self.mount_m
        return [origin + line @ rotation.T for line in (circle, rim, *edges)]


@dataclass(frozen=True)
class Shapes:
    """rod_m: length of the object along its z axis, None: there is none. crank_m: (radius, length of the handle)."""

    rod_m: float | None = None
    crank_m: tuple[float, float] | None = None
    robot_cup: Cup | None = None
    person_cup: Cup | None = None


def axis_angle_product(factors: list[dict]) -> np.ndarray:
    """[{axis: x, angle_deg: 90}, ...], multiplied from left to right, as a (3, 3) rotation."""
    result = np.eye(3)
    for factor in factors:
        half = np.radians(float(factor["angle_deg"])) / 2
        quaternion = np.zeros((1, 4))
        quaternion[0, 0], quaternion[0, 1 + "xyz".index(factor["axis"])] = np.cos(half), np.sin(half)
        result = result @ rotation_matrices(quaternion)[0]
    return result


def _cup(section: dict | None) -> Cup | None:
    if not section:
        return None
    return Cup(
        float(section["radius_m"]),
        float(section["height_m"]),
        np.array(section.get("mount_m", [0, 0, 0]), float),
        axis_angle_product(section.get("mount_rotation", [])),
    )


def read_shapes(scenario: str) -> Shapes:
    """Of the built-in scenario of this name; of another one nothing is known."""
    path = SCENARIOS / f"{scenario}.yaml"
    if not path.is_file():
        return Shapes()
    document = yaml.safe_load(path.read_text())
    thing = next((item for item in (document.get("objects") or {}).values() if item["kind"] != "stand"), {})
    tracked = next((person for person in document["people"].values() if person.get("tracked")), {})
    is_crank = thing.get("kind") == "crank"
    return Shapes(
        rod_m=float(thing["length_m"]) if thing and not is_crank else None,
        crank_m=(float(thing["radius_m"]), float(thing["length_m"])) if is_crank else None,
        robot_cup=_cup((document.get("robot") or {}).get("cup")),
        person_cup=_cup(tracked.get("cup")),
    )
