"""The reach of the arm agrees with brute force: the positions of actual postures are in reach, and no sampled posture
comes closer to a target than the posture that the search finds."""

from __future__ import annotations

import hoap3
import numpy as np
import plant_binding
import pytest
from scipy.spatial import cKDTree

TOLERANCE_M = 1e-3
RANGE = np.radians(hoap3.STOPS_DEG + [1.0, -1.0])


@pytest.fixture(scope="module")
def sim():
    return plant_binding.load()


@pytest.fixture(scope="module")
def brute_force():
    """Returns a k-d tree of a million sampled positions of the end effector. In the samples, a quarter of the joints
    are at a limit, because such postures form the boundary of the workspace."""
    rng = np.random.default_rng(3)
    q = rng.uniform(RANGE[:, 0], RANGE[:, 1], (1_000_000, 4))
    at_end = rng.random(q.shape) < 0.25
    q = np.where(at_end, RANGE[np.arange(4), rng.integers(0, 2, q.shape)], q)
    return cKDTree(hoap3.hands(q))


class Search:
    def __init__(self, sim):
        self.ffi, self.lib = sim
        self.state = self.ffi.new("reach_t *")
        self.forget()

    def forget(self):
        self.lib.reach_init(self.state)

    def _arguments(self, target, measured):
        return self.state, self.ffi.new("double[3]", list(target)), self.ffi.new("double[4]", list(measured))

    def distance(self, target, measured):
        return self.lib.reach_distance_m(*self._arguments(target, measured))

    def contains(self, target, measured):
        return self.lib.reach_contains(*self._arguments(target, measured))

    def posture(self):
        return np.array(list(self.state.position_rad))


def random_targets(rng, count):
    """Returns positions in a box slightly larger than the workspace, which extends 0.282 m around the shoulder."""
    return np.array([-0.035, -0.111, 0.125]) + rng.uniform(-0.33, 0.33, (count, 3))


def test_positions_of_postures_are_in_reach(sim, rng):
    search = Search(sim)
    postures = rng.uniform(RANGE[:, 0], RANGE[:, 1], (3000, 4))
    for target, measured in zip(hoap3.hands(postures), rng.permutation(postures), strict=True):
        search.forget()
        assert search.distance(target, measured) <= TOLERANCE_M


def test_found_posture_is_valid(sim, rng):
    """The posture found is within the joint limits, and its end effector is at the reported distance from the
    target."""
    search = Search(sim)
    for target in random_targets(rng, 500):
        distance = search.distance(target, rng.uniform(RANGE[:, 0], RANGE[:, 1]))
        posture = search.posture()
        assert (posture >= RANGE[:, 0] - 1e-12).all() and (posture <= RANGE[:, 1] + 1e-12).all()
        assert np.linalg.norm(hoap3.frames(posture)[4][:3, 3] - target) == pytest.approx(distance, abs=1e-12)


def test_no_sampled_posture_is_better(sim, rng, brute_force):
    search, outside = Search(sim), 0
    for target in random_targets(rng, 1500):
        search.forget()
        distance = search.distance(target, rng.uniform(RANGE[:, 0], RANGE[:, 1]))
        nearest = brute_force.query(target)[0]
        if nearest < 0.1:
            assert distance <= max(nearest, TOLERANCE_M) + 1e-4
        else:  # far from the workspace, the search may miss the best posture; reach_contains() allows for this
            assert distance <= 1.1 * nearest
        outside += distance > TOLERANCE_M
    assert 300 < outside < 1400  # both cases occur often enough


def test_shortcut_along_a_path_changes_no_answer(sim, rng):
    """Along a path that leaves and re-enters the reach, reach_contains() skips some searches, but its answers are those
    of a full search."""
    walking, fresh = Search(sim), Search(sim)
    target, velocity, answers = np.array([0.1, -0.15, 0.0]), np.zeros(3), set()
    for _ in range(4000):
        velocity = 0.98 * velocity + rng.normal(0, 3e-4, 3) - 1e-3 * (target - [0.05, -0.2, 0.05])
        target = target + velocity
        measured = rng.uniform(RANGE[:, 0], RANGE[:, 1])
        fresh.forget()
        distance = fresh.distance(target, measured)
        answer = walking.contains(target, measured)
        if abs(distance - TOLERANCE_M) > 2e-4:  # at the boundary, rounding decides where a search ends
            assert answer == (distance <= TOLERANCE_M)
        answers.add(answer)
    assert answers == {True, False}
