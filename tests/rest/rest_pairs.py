"""Checks pairs of parameters at the ends of their ranges: the arm must come to rest, unless the firmware rejects the
set or warns that rest is not assured."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import rest_arm as arm
import rest_judgement as judgement
from rest_loop import ACCEPTED, MAY_SWING, UNSTABLE, Loop

GROUPS = {
    "rotation": range(4),
    "translation": range(4, 8),
    "all": range(8),
}  # components of K and of W that are changed together
VECTORS = {"gain": "gain_w_per_s", "weight": "weight_w"}  # name of each vector's first component
SPEED_RADPS = 4.76  # speed limit of HOAP-3's joints
OF_SPEED = 0.1  # share of the speed limit below which a joint counts as at rest
SPEED_FRACTION = "speed_fraction"


@dataclass(frozen=True)
class End:
    """A parameter, or a group of parameters, at an end of its range."""

    name: str
    parameters: frozenset[str]
    value: float


@dataclass(frozen=True)
class Verdict:
    """The verdict on a pair. `what` is "refused", "rests", "oscillates", "moves" or "was interrupted". `warned` is set
    if the firmware reports that it cannot ensure rest."""

    pair: str
    what: str
    warned: bool
    peak_radps: float


def ends(loop: Loop) -> list[End]:
    """Returns both ends of each parameter in the firmware's table, and of each group."""
    single = [
        End(name, frozenset([name]), value)
        for name, both in zip(loop.names, loop.ranges, strict=True)
        for value in both
    ]
    grouped = []
    for vector, first in VECTORS.items():
        begin = loop.names.index(first)
        for group, components in GROUPS.items():
            names = frozenset(loop.names[begin + i] for i in components)
            grouped += [End(f"{vector}_{group}", names, value) for value in loop.ranges[begin]]
    return single + grouped


def pairs(loop: Loop) -> list[tuple[End, End]]:
    """Returns all pairs of ends, except those that have a parameter in common: a parameter cannot be at both ends of
    its range at once."""
    return [(a, b) for a, b in itertools.combinations(ends(loop), 2) if not a.parameters & b.parameters]


def written(pair: tuple[End, End]) -> dict[str, float]:
    return {name: end.value for end in pair for name in sorted(end.parameters)}


def speed_radps(parameters: dict[str, float]) -> float:
    return parameters.get(SPEED_FRACTION, 1.0) * SPEED_RADPS


def travel_s(parameters: dict[str, float]) -> float:
    """Returns how much longer all joints take to cross their ranges, one after the other, at the allowed speed than at
    full speed. The time at full speed is already included in the 8 s."""
    way_rad = float(np.ptp(arm.RANGE_RAD, axis=1).sum())
    return way_rad / speed_radps(parameters) - way_rad / SPEED_RADPS


def judge(pair: tuple[End, End], outcomes: np.ndarray) -> Verdict:
    name = " ".join(f"{end.name}={end.value:g}" for end in pair)
    warned = bool((outcomes["verdict"] == MAY_SWING).any())
    if (outcomes["start"] == UNSTABLE).all():
        return Verdict(name, "refused", warned, 0.0)
    peak_radps = float(outcomes["peak_radps"][:, judgement.LATE].max())
    allowed_radps = max(judgement.CREEP_RADPS, OF_SPEED * speed_radps(written(pair)))
    if (outcomes["start"] != ACCEPTED).any() or outcomes["interrupted"].any():
        return Verdict(name, "was interrupted", warned, peak_radps)
    if judgement.oscillates(outcomes, judgement.LATE).any():
        return Verdict(name, "oscillates", warned, peak_radps)
    return Verdict(name, "rests" if peak_radps <= allowed_radps else "moves", warned, peak_radps)
