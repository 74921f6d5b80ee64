"""Checks that `make bench` evaluates its measurements correctly, and that all the libraries it compares get inputs that
follow Algorithm 1."""

from __future__ import annotations

import sys

import numpy as np
import oracle
import pytest
from simulation import REPOSITORY

sys.path.insert(0, str(REPOSITORY / "tests" / "bench"))
import bench  # noqa: E402


def measured(ours: float, pinocchio: float, wdls: float, heap: float = 0.0) -> dict[str, dict]:
    def entry(ns: float, allocations: float = 0.0) -> dict:
        return {"times_ours": ns / ours, "heap_allocations": allocations}

    return {
        bench.OURS[0]: entry(ours, heap),
        bench.OURS[1]: entry(ours),
        "Pinocchio, double": entry(pinocchio),
        "KDL, wdls": entry(wdls),
    }


def test_a_missed_ratio_is_reported():
    assert bench.missed(4, measured(100, 501, 2001)) == []
    assert bench.missed(4, measured(100, 490, 2001)) == [
        "n = 4: Pinocchio, double takes 4.9 times as long as ours, required 5"
    ]
    assert bench.missed(6, measured(100, 501, 1950)) == [
        "n = 6: KDL, wdls takes 19.5 times as long as ours, required 20"
    ]


def test_heap_allocations_are_reported():
    assert bench.missed(7, measured(100, 600, 3000, heap=0.5)) == [
        "n = 7: comanip, specialised: 0.5 heap allocations per tick"
    ]


def test_a_ratio_is_the_median_of_the_rounds_ratios():
    """The ratio does not change if both contenders take twice as long in one round."""
    times = {bench.OURS[0]: [10.0, 20.0, 10.0], "KDL, wdls": [200.0, 400.0, 260.0]}
    assert bench.times_ours(times, "KDL, wdls") == 20.0


def test_rounds_are_a_median_and_its_spread():
    assert bench.summary(list(range(101))) == {"median": 50, "percentile_10": 10, "percentile_90": 90}


def test_lines_are_gathered_by_contender():
    assert bench.rows("a, b\t1\t2\nc\t3\t4\na, b\t5\t6\n") == {"a, b": [[1, 2], [5, 6]], "c": [[3, 4]]}


@pytest.mark.parametrize("n", bench.ARMS)
def test_the_constants_for_the_peers_are_algorithm_1(n, tmp_path):
    """The closed form in contender.hpp agrees with the paper's Algorithm 1, evaluated line by line with dqrobotics' own
    decompositional product."""
    case = bench.make_case(n, tmp_path, np.random.default_rng(0))
    lines = [list(map(float, line.split())) for line in case.model.read_text().splitlines()[1 + n + 1 :]]
    left, right, relation = np.array(lines[0]), np.array(lines[1]), np.array(lines[2])
    for hand in case.hands[::97]:
        turned = oracle.quaternion_multiply(oracle.quaternion_multiply(left[:4], hand[:4]), right[:4])
        place = (
            right[4:] + oracle.rotate(left[:4], oracle.translation(hand) - left[4:]) - oracle.rotate(turned, relation)
        )
        expected = case.algorithm.target(oracle.unit(hand))
        assert oracle.pose_distance(oracle.pose(turned, place), expected) < 1e-6


def test_the_reference_kinematics_match_dqrobotics():
    case_arm = bench.arm_description.read(bench.ARMS[4])
    q = np.array([0.2, -0.7, 0.4, -1.1])
    hand, jacobian = bench.kinematics(case_arm, q)
    expected, expected_jacobian = (x[0] for x in oracle.evaluate(oracle.hoap3(), q[None]))
    sign = np.sign(hand[:4] @ expected[:4])
    assert np.abs(sign * hand - expected).max() < 1e-12
    assert np.abs(sign * jacobian - expected_jacobian).max() < 1e-12
