"""Generates random cases of a hand that moves once and then rests. A case depends only on the name of the seed series
and on its number, so that a single case can be repeated."""

from __future__ import annotations

import itertools
import zlib

import numpy as np
import rest_arm as arm
from rest_loop import CASE

SEEDS = ("choice", "proof")  # seed series: one for tuning the parameters, one for validating them
END_S = (8.0, 20.0)  # ends of the two windows, from the start of the move
REACHABLE_FIRST, PAIRS_FIRST = 1_000_000, 2_000_000  # first case numbers of the reachable cases and of the pairs


def direction(rng: np.random.Generator) -> np.ndarray:
    vector = rng.normal(size=3)
    return vector / np.linalg.norm(vector)


def random_case(seeds: str, number: int, end_s: tuple[float, float] = END_S) -> np.ndarray:
    rng = np.random.default_rng([zlib.crc32(seeds.encode()), number])
    case = np.zeros((), CASE)
    case["start_rad"] = rng.uniform(*arm.RANGE_RAD.T)
    rotation = rng.normal(size=4)
    case["hand_rotation"] = rotation / np.linalg.norm(rotation)
    case["way_m"] = rng.uniform(0.05, 2.0) * direction(rng)
    case["turn_rad"] = rng.uniform(0.0, np.pi) * direction(rng)
    case["move_s"] = rng.uniform(0.5, 2.0)
    case["dead_time_s"] = rng.uniform(0.0, 3e-3)
    case["lag_s"] = rng.uniform(1e-3, 10e-3)
    case["end_s"] = end_s
    return case


def random_cases(seeds: str, numbers: range) -> np.ndarray:
    return np.array([random_case(seeds, number) for number in numbers], CASE)


def in_torso_axes(vector: np.ndarray) -> np.ndarray:
    """Converts a vector in the tracker's axes to torso axes, by the paper's equation (9)."""
    x, y, z = vector
    return np.array([x, -z, y])


def target_m(case: np.ndarray) -> np.ndarray:
    """Returns the position to which task teleop would finally bring the end effector: the end effector's start position
    plus the hand's displacement."""
    return arm.hand_m(case["start_rad"]) + in_torso_axes(case["way_m"])


def reachable_cases(seeds: str, count: int) -> np.ndarray:
    """Returns the first `count` cases of a separate series, all with a reachable target position. The cases last
    8 s."""
    further = (random_case(seeds, number, (END_S[0], END_S[0])) for number in itertools.count(REACHABLE_FIRST))
    return np.array(
        list(itertools.islice((case for case in further if len(arm.reaching(target_m(case)))), count)), CASE
    )


def pair_cases(seeds: str, count: int, travel_s: float) -> np.ndarray:
    """Returns cases for checking sets of parameters. The drives are like the simulator's, and the cases last 8 s plus
    `travel_s`."""
    end_s = END_S[0] + travel_s
    cases = np.array([random_case(seeds, PAIRS_FIRST + number, (end_s, end_s)) for number in range(count)], CASE)
    cases["lag_s"], cases["dead_time_s"] = 3e-3, 0.0
    return cases
