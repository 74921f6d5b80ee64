"""Tests the cases and the arithmetic of `make rest`, and that these checks fail for the former control law, with which
the arm oscillates."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import hoap3
import numpy as np
import pytest
from images import make
from scipy.optimize import least_squares
from simulation import REPOSITORY

sys.path.insert(0, str(REPOSITORY / "tests" / "rest"))
import rest  # noqa: E402
import rest_arm  # noqa: E402
import rest_cases  # noqa: E402
import rest_judgement  # noqa: E402
import rest_loop  # noqa: E402
import rest_ode  # noqa: E402
import rest_pairs  # noqa: E402

BUILD = Path(os.environ.get("COMANIP_SANITISED", REPOSITORY / "build"))


@pytest.fixture(scope="module", autouse=True)
def loop() -> rest_loop.Loop:
    # Rebuilds the library, so that it never contains older firmware.
    built = make(str(BUILD.relative_to(REPOSITORY) / "rest" / "loop.so"))
    assert built.returncode == 0, built.stderr
    return rest_loop.Loop(BUILD)


# ---- the arm in double precision


def test_the_end_effector_position_matches_the_manuals_table(rng):
    for q in rng.uniform(*rest_arm.RANGE_RAD.T, size=(100, 4)):
        assert np.abs(rest_arm.hand_m(q) - hoap3.frames(q)[4][:3, 3]).max() < 1e-12


def test_postures_found_for_a_position_reach_it(rng):
    for q in rng.uniform(*rest_arm.RANGE_RAD.T, size=(100, 4)):
        found = rest_arm.reaching(rest_arm.hand_m(q))
        assert len(found) > 0
        assert np.abs(rest_arm.hand_m(found) - rest_arm.hand_m(q)).max() < 1e-9


def test_a_position_without_posture_is_not_found_by_a_search_either(rng):
    """If reaching() finds no posture for a position around the shoulder, a bounded least-squares search from six random
    postures finds none either."""
    for position in rest_arm.SHOULDER_M + rng.uniform(-0.35, 0.35, size=(25, 3)):
        best_m = min(
            np.sqrt(2 * least_squares(lambda q: rest_arm.hand_m(q) - position, start, bounds=rest_arm.RANGE_RAD.T).cost)
            for start in rng.uniform(*rest_arm.RANGE_RAD.T, size=(6, 4))
        )
        if len(rest_arm.reaching(position)) == 0:
            assert best_m > 1e-4, position
        else:
            assert best_m < 1e-2, position  # occasionally the search gets stuck at a joint limit


def test_the_valley_matches_half_the_squared_distance(rng):
    """The slope and the curvature that rest_arm.valley() returns match first and second differences of half the squared
    distance to the position."""
    inside = rest_arm.RANGE_RAD.T + np.outer([1, -1], np.full(4, 0.05))
    for q in rng.uniform(*inside, size=(20, 4)):
        position, h = rest_arm.hand_m(q) + rng.normal(0, 0.1, 3), 1e-3

        def half_square(x: np.ndarray) -> float:
            return 0.5 * float(np.sum((rest_arm.hand_m(x) - position) ** 2))

        unit = h * np.eye(4)
        slope = [(half_square(q + u) - half_square(q - u)) / (2 * h) for u in unit]
        bend = [
            [
                (half_square(q + u + v) - half_square(q + u - v) - half_square(q - u + v) + half_square(q - u - v))
                / (4 * h * h)
                for v in unit
            ]
            for u in unit
        ]
        valley = rest_arm.valley(q, position)
        assert valley.limits == ()
        assert valley.slope_m2 == pytest.approx(np.linalg.norm(slope), rel=1e-4)
        assert valley.curvature_m2 == pytest.approx(np.linalg.eigvalsh(bend), abs=1e-5)


def test_the_descent_by_position_ends_in_a_local_minimum(rng):
    """The descent stays within the joint limits, never increases the distance, and ends where no sampled posture nearby
    is better."""
    starts = rng.uniform(*rest_arm.RANGE_RAD.T, size=(40, 4))
    positions = rest_arm.hand_m(rng.uniform(*rest_arm.RANGE_RAD.T, size=(40, 4)))
    ends = rest_arm.descend(starts, positions)
    assert (ends >= rest_arm.RANGE_RAD[:, 0]).all() and (ends <= rest_arm.RANGE_RAD[:, 1]).all()
    left_m = np.linalg.norm(positions - rest_arm.hand_m(ends), axis=1)
    assert (left_m <= np.linalg.norm(positions - rest_arm.hand_m(starts), axis=1) + 1e-9).all()
    assert 0.5 < np.mean(left_m < 1e-4) < 1.0, "most arrive, but not all"
    for q, position, left in zip(ends, positions, left_m, strict=True):
        around = np.clip(q + 0.01 * rng.uniform(-1, 1, (200, 4)), *rest_arm.RANGE_RAD.T)
        assert np.linalg.norm(position - rest_arm.hand_m(around), axis=1).min() > left - 1e-3


# ---- cases and their judgement


def test_the_seeds_for_choice_and_proof_differ():
    choice, proof = (rest_cases.random_cases(seeds, range(50)) for seeds in rest_cases.SEEDS)
    assert not np.isin(choice["start_rad"], proof["start_rad"]).any()
    assert (choice == rest_cases.random_cases("choice", range(50))).all()


def test_the_target_matches_algorithm_1(loop):
    cases = rest_cases.random_cases("choice", range(20))
    cases["end_s"] = 4.0
    outcomes = loop.run(cases, {})
    assert (outcomes["start"] == rest_loop.ACCEPTED).all() and not outcomes["interrupted"].any()
    expected = [rest_cases.target_m(case) for case in cases]
    assert np.abs(outcomes["target"][:, 4:] - expected).max() < 1e-4  # the start is measured in encoder pulses


def outcome(peak_radps: float, sign_changes: int, joint: int = 2) -> np.ndarray:
    one = np.zeros(1, rest_loop.OUTCOME)
    one["peak_radps"][0, :, joint], one["sign_changes"][0, :, joint] = peak_radps, sign_changes
    return one


@pytest.mark.parametrize(
    ("peak_radps", "sign_changes", "expected"),
    [(0.0199, 50, "rests"), (0.0201, 2, "creeps"), (0.0201, 3, "oscillates"), (4.0, 0, "creeps"), (0.0, 0, "rests")],
)
def test_oscillating_and_creeping_are_told_apart(peak_radps, sign_changes, expected):
    one = outcome(peak_radps, sign_changes)
    for window in (rest_judgement.EARLY, rest_judgement.LATE):
        oscillates, creeps = rest_judgement.oscillates(one, window)[0], rest_judgement.creeps(one, window)[0]
        assert ("oscillates" if oscillates else "creeps" if creeps else "rests") == expected


def test_the_checks_and_their_limits():
    """Each check passes if all cases are at rest, and fails if there is one bad case more than the check tolerates."""
    good = np.repeat(outcome(0.0, 0), 1000)
    assert all(check.passed for check in rest.rest(good)[0])
    for count, bad, failed in (
        (1, outcome(0.03, 9), [1, 3]),
        (3, outcome(0.03, 0), [4]),
        (16, outcome(0.03, 0), [2, 4]),
    ):
        outcomes = good.copy()
        outcomes[:count] = bad
        checks, exceptions = rest.rest(outcomes)
        assert [i for i, check in enumerate(checks) if not check.passed] == failed
        assert [entry["case"] for entry in exceptions["rest_of_20_s"]] == list(range(count))
    outcomes = good.copy()
    outcomes["interrupted"][7, 0] = 1
    assert [i for i, check in enumerate(rest.rest(outcomes)[0]) if not check.passed] == [0]


def test_the_drive_is_a_dead_time_and_a_lag(loop):
    """The drives follow their commands with a dead time and a first-order lag, and do not drift. If the hand never
    moves, no joint moves."""
    cases = rest_cases.random_cases("choice", range(5))
    cases["way_m"], cases["turn_rad"], cases["end_s"] = 0.0, 0.0, 3.0
    outcomes = loop.run(cases, {})
    assert np.abs(outcomes["position_rad"][:, 0] - cases["start_rad"]).max() < 1e-3


def test_a_reversal_counts_only_between_speeds_above_rest(tmp_path):
    """In the first window of the trace, the velocity alternates between 0.03 and -0.03, with 0.01 of the opposite sign
    in between, and each reversal counts once. In the second window, it alternates between 0.019 and -0.019, and no
    reversal counts."""
    case = rest_cases.random_case("choice", 0)
    case["end_s"] = (2.0, 4.0)
    rates = np.zeros(4300)
    rates[100:2100] = np.tile(np.repeat([0.03, -0.01, -0.03, 0.01], 50), 10)
    rates[2100:4100] = np.tile([0.019, -0.019], 1000)
    names = [f"dq{i}_command_radps" for i in range(4)] + [f"q{i}_rad" for i in range(4)]
    names += [f"target_{name}" for name in ("qw", "qx", "qy", "qz", "x_m", "y_m", "z_m")]
    rows = [",".join(["mode", *names])] + [
        ",".join(["cooperating", f"{rate:.4f}", *["0"] * (len(names) - 1)]) for rate in rates
    ]
    (tmp_path / "trace.csv").write_text("\n".join(rows))
    found = rest_ode.outcome(case, tmp_path / "trace.csv")
    assert found["peak_radps"][:, 0] == pytest.approx([0.03, 0.019])
    assert found["sign_changes"][:, 0].tolist() == [19, 0]
    assert not found["interrupted"].any()


# ---- pairs of parameters


def test_all_pairs_are_counted(loop):
    """The pairs combine the ends of the ranges of all parameters and of six groups of parameters, except pairs that
    would set a parameter twice."""
    n = len(loop.names)
    assert {end.name: len(end.parameters) for end in rest_pairs.ends(loop) if len(end.parameters) > 1} == {
        f"{vector}_{group}": size
        for vector in ("gain", "weight")
        for group, size in (("rotation", 4), ("translation", 4), ("all", 8))
    }
    # Disjoint pairs within a vector of 8 components and 3 groups: 28 pairs of two components, 4 + 4 pairs of a
    # component and the group of the other half, and the pair of the two halves.
    within = 28 + 8 + 1
    apart = (n + 6) * (n + 5) // 2 - 2 * (11 * 10 // 2) + 2 * within
    found = rest_pairs.pairs(loop)
    assert len(found) == 4 * apart
    assert all(not a.parameters & b.parameters for a, b in found)


@pytest.mark.parametrize(
    ("fraction", "peak_radps", "sign_changes", "expected"),
    [
        (1.0, 0.47, 2, "rests"),
        (1.0, 0.48, 2, "moves"),
        (1.0, 0.021, 3, "oscillates"),
        (0.01, 0.0199, 9, "rests"),
        (0.01, 0.021, 0, "moves"),
    ],
)
def test_a_pair_is_judged_by_its_allowed_speed(fraction, peak_radps, sign_changes, expected):
    pair = (
        rest_pairs.End("speed_fraction", frozenset(["speed_fraction"]), fraction),
        rest_pairs.End("trace", frozenset(["trace"]), 0.0),
    )
    verdict = rest_pairs.judge(pair, outcome(peak_radps, sign_changes))
    assert (verdict.pair, verdict.what, verdict.warned) == (f"speed_fraction={fraction:g} trace=0", expected, False)
    refused = outcome(peak_radps, sign_changes)
    refused["start"] = rest_loop.UNSTABLE
    assert rest_pairs.judge(pair, refused).what == "refused"


def test_a_refused_set_is_not_run(loop):
    assert (
        loop.run(rest_cases.pair_cases("choice", 1, 0.0), {"gain_x_per_s": 500.0, "prediction": 0.0})["start"]
        == rest_loop.UNSTABLE
    )


# ---- the campaign


def test_the_simulator_runs_the_same_case(loop, tmp_path):
    """In a short motion within reach, the simulator and the loop in tests/rest have the same target, and their joints
    reach the same posture. The loop's drives behave like ODE's."""
    case = rest_cases.random_case("choice", 0)
    case["start_rad"], case["way_m"], case["turn_rad"] = (
        np.radians([60, -30, -10, -80]),
        [0.02, 0.03, -0.01],
        [0.1, -0.05, 0.1],
    )
    case["end_s"], case["lag_s"], case["dead_time_s"] = (3.0, 4.0), 3e-3, 0.0
    expected = loop.run(case[None], {})[0]
    found = rest_ode.run(case, REPOSITORY / "build" / "host" / "comanip-sim", tmp_path, {})
    assert not found["interrupted"].any()
    assert np.abs(found["target"][4:] - expected["target"][4:]).max() < 1e-4
    assert np.abs(found["position_rad"] - expected["position_rad"]).max() < 5e-3
    assert found["peak_radps"].max() < rest_judgement.CREEP_RADPS


def campaign(folder: Path, *arguments: str) -> tuple[int, dict]:
    file = folder / "rest.json"
    status = rest.main([str(BUILD), "--seeds", "choice", "--out", str(file), *arguments])
    return status, json.loads(file.read_text())


FORMER_LAW = ("--parameter", "prediction=0")


def test_the_checks_fail_on_the_former_law(tmp_path):
    """With the former law a quarter of the cases oscillate, 8 % creep, and half of the positions are missed."""
    status, report = campaign(tmp_path, "--cases", "60", "--reachable", "60", "--ode", "0", "--pairs", "0", *FORMER_LAW)
    assert status == 1
    assert [check["name"] for check in report["checks"] if check["passed"]] == ["rest: not in cooperation"]
    assert all(entry["cause"] for entries in report["exceptions"].values() for entry in entries)


def test_the_present_law_rests_in_a_small_campaign(tmp_path):
    """`make rest` runs 5,000 cases, and this test only a few. All figures must be zero, with two exceptions: 2.5 % of
    the cases may creep at 8 s, and it suffices to reach 90 % of the reachable positions instead of 95 %."""
    _, report = campaign(tmp_path, "--cases", "40", "--reachable", "40", "--ode", "0", "--pairs", "0")
    values = {check["name"]: check["value"] for check in report["checks"]}
    assert values.pop("rest: share creeping in the last 2 s of 8 s") <= 0.025
    assert values.pop("position: share within 1 mm where reachable, with posture_change") >= 0.9
    assert set(values.values()) == {0}
