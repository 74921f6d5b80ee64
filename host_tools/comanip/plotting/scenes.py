"""What the trace does not hold of the five experiments: sizes of the things in them, as their scenario files have them,
and the instants that tell the story, as the paper's Figs. 5 to 7 do."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Cup:
    """Seen from the hand that carries it: the centre of its inner bottom, and the axis to its opening."""

    carrier: str  # "hand" or "person"
    mount_m: tuple[float, float, float]
    axis: tuple[float, float, float]
    radius_m: float
    height_m: float


@dataclass(frozen=True)
class Scene:
    """`instants`: (event, seconds after it, caption), in time's order. `view_deg`: azimuth, elevation of the eye."""

    title: str
    instants: tuple[tuple[str, float, str], ...]
    decisive: str  # "water", "carrying", "handing", "crank", "tracking"
    view_deg: tuple[float, float] = (-62.0, 16.0)
    rod_length_m: float = 0.0
    crank_radius_m: float = 0.0
    crank_handle_m: float = 0.0  # its length
    cups: tuple[Cup, ...] = ()


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
        cups=(
            Cup("hand", (0.0098, 0.0173, 0.0017), (0.49207, 0.86618, 0.08716), 0.034, 0.021),
            Cup("person", (0.0, 0.0, 0.06), (1.0, 0.0, 0.0), 0.045, 0.08),
        ),
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
        rod_length_m=0.28,
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
        rod_length_m=0.32,
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
        rod_length_m=0.20,
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
        crank_radius_m=0.025,
        crank_handle_m=0.24,
    ),
}
