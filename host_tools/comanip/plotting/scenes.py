"""Defines the snapshots of each of the five experiments, as in the paper's Figs. 5 to 7, and the curves that show
whether the experiment succeeded."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Scene:
    """The layout of an experiment's figure. instants: (event, seconds after it, caption) of the snapshots, sorted by
    time. view_deg: azimuth and elevation of the viewpoint."""

    title: str
    instants: tuple[tuple[str, float, str], ...]
    decisive: str  # the curves that show whether it succeeded: "water", "carrying", "handing", "crank" or "tracking"
    view_deg: tuple[float, float] = (-62.0, 16.0)


SCENES = {
    "pour": Scene(
        "Water pouring",
        (
            ("operator.pouring", 0.0, "upright, at spot 1"),
            ("person.at_spot_2", 0.0, "pouring, spot 2"),
            ("person.at_spot_3", 0.0, "spot 3"),
            ("person.at_spot_4", 0.0, "spot 4"),
        ),
        "water",
        view_deg=(-28.0, 12.0),
    ),
    "teleop": Scene(
        "Teleoperation and handing over",
        (
            ("operator.started", 0.0, "start"),
            ("robot.holds", 0.0, "the gripper holds the pipe"),
            ("taker.holds", 0.0, "the second person grips it"),
            ("taker.away", 0.0, "and carries it away"),
        ),
        "handing",
    ),
    "mirror": Scene(
        "Simultaneous handling",
        (
            ("operator.started", 0.0, "face to face"),
            ("person.back", 0.0, "backwards, mirrored"),
            ("operator.latched", 0.0, "grasped and latched"),
            ("person.carried", 0.0, "carried together"),
        ),
        "carrying",
    ),
    "handover": Scene(
        "Handing over an object",
        (
            ("operator.started", 0.0, "start"),
            ("person.reaching", 0.0, "the hands meet"),
            ("person.holds", 0.0, "the person grips"),
            ("person.away", 0.0, "and takes it away"),
        ),
        "handing",
    ),
    "crank": Scene(
        "Turning a crank",
        (
            ("person.holds", 0.0, "both hold the handle"),
            ("operator.started", 4.0, "turning"),
            ("operator.started", 9.0, "turning"),
            ("person.turned", 0.0, "turned"),
        ),
        "crank",
    ),
}
