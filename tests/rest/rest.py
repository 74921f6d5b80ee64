"""``make rest``: checks that the arm, controlled with position priority, comes to rest when the hand rests.

``rest.py BUILD [--seeds choice|proof] [--cases N] [--reachable N] [--ode N] [--pairs N] [--parameter NAME=VALUE ...]
[--out FILE]``. Random cases (rest_cases.py) run for 20 s each through the firmware's controller_step() in a loop with
drives (loop.c), and some of them in the simulator (rest_ode.py). The requirements are:

    rest      from 6 s to 8 s after the start of the move, no case oscillates and at most 1.5 % of the cases creep; from
              18 s to 20 s, no case oscillates and at most 0.2 % creep (rest_judgement.py)
    ode       the requirement `rest` for a hundred cases in the simulator
    position  95 % of the cases with a reachable target position (rest_arm.py) are within 1 mm of it after 8 s
    pairs     two parameters, or groups of components of K and W, are set to ends of their ranges, for all pairs. Unless
              the firmware rejects the set or warns that rest is not assured, the arm must rest after 8 s plus the
              additional travel time at a reduced speed limit: no joint oscillates or is faster than the larger of 0.02
              rad/s and 10 % of the speed limit (rest_pairs.py)

Each exception is listed with its cause, which is derived from the arm's final posture. Outcomes are stored in
BUILD/rest/outcomes, separately for each build of the loop and of the simulator, so that an interrupted campaign can
continue. Prints the figures and writes FILE. The exit status is 1 if a requirement is missed.
"""

from __future__ import annotations

import argparse
import collections
import dataclasses
import functools
import hashlib
import itertools
import json
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

import rest_arm as arm  # noqa: E402
import rest_cases as generated  # noqa: E402
import rest_judgement as judgement  # noqa: E402
import rest_ode  # noqa: E402
import rest_pairs  # noqa: E402
from rest_loop import ACCEPTED, OUTCOME, Loop  # noqa: E402

CASES, REACHABLE, ODE, PAIR_CASES = 5000, 2000, 100, 4
PAIRS_BATCH = 50
BATCH = 250  # number of cases stored at a time
WITHIN_M, WITHIN_SHARE = 1e-3, 0.95
FLAT_M2 = 5e-4  # m2/rad2; smaller curvatures are small compared with the square of a link's length, at least 0.01 m2


class Campaign:
    """Computes outcomes of cases, or reads them if they are already stored."""

    def __init__(self, build: Path, seeds: str, parameters: dict[str, float]) -> None:
        self.loop = Loop(build)
        self.seeds, self.parameters = seeds, parameters
        self._folder = build / "rest" / "outcomes"
        self._folder.mkdir(parents=True, exist_ok=True)
        self._simulator = build / "host" / "comanip-sim"

    def outcomes(self, cases: np.ndarray) -> np.ndarray:
        parts = [self._batch(cases[first : first + BATCH]) for first in range(0, len(cases), BATCH)]
        return np.concatenate(parts) if parts else np.zeros(0, OUTCOME)

    def in_ode(self, count: int) -> np.ndarray:
        """Returns the outcomes of the first `count` cases that do not start with the arm inside the robot's body."""
        cases = (generated.random_case(self.seeds, number) for number in itertools.count())
        outcomes = (self._kept(self._ode_fingerprint, case, self._simulate) for case in cases)
        return np.array(
            list(itertools.islice((one for one in outcomes if one["start"] != rest_ode.NO_PLACE), count)), OUTCOME
        )

    def of_pairs(self, count: int) -> list[rest_pairs.Verdict]:
        """Returns the verdict on each pair, from `count` cases per pair."""
        sets = [(pair, self.parameters | rest_pairs.written(pair)) for pair in rest_pairs.pairs(self.loop)]
        found = []
        for first in range(0, len(sets), PAIRS_BATCH):
            batch = sets[first : first + PAIRS_BATCH]
            cases = [
                generated.pair_cases(self.seeds, count, rest_pairs.travel_s(parameters)) for _, parameters in batch
            ]

            def run(_: np.ndarray, batch=batch, cases=cases) -> np.ndarray:
                return np.array(
                    [self.loop.run(these, parameters) for (_, parameters), these in zip(batch, cases, strict=True)]
                )

            outcomes = self._kept(f"{self.loop.fingerprint} pairs from {first}", np.array(cases), run)
            found += [rest_pairs.judge(pair, these) for (pair, _), these in zip(batch, outcomes, strict=True)]
        return found

    def _batch(self, cases: np.ndarray) -> np.ndarray:
        return self._kept(self.loop.fingerprint, cases, lambda cases: self.loop.run(cases, self.parameters))

    @functools.cached_property
    def _ode_fingerprint(self) -> str:
        return hashlib.sha256(self._simulator.read_bytes()).hexdigest()

    def _simulate(self, case: np.ndarray) -> np.ndarray:
        with tempfile.TemporaryDirectory() as folder:
            return rest_ode.run(case, self._simulator, Path(folder), self.parameters)

    def _kept(self, fingerprint: str, cases: np.ndarray, run: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        what = json.dumps([fingerprint, sorted(self.parameters.items())]).encode() + cases.tobytes()
        file = self._folder / f"{hashlib.sha256(what).hexdigest()[:24]}.npy"
        if file.exists():
            return np.load(file)
        outcomes = run(cases)
        unfinished = file.with_suffix(".part")
        with unfinished.open("wb") as stream:
            np.save(stream, outcomes)
        unfinished.replace(file)
        return outcomes


# ---- causes


def position_cause(left_m: float) -> str:
    """Returns the reason why a position error remains. `left_m`: the error that would be left if the arm continued
    without regard to the orientation (rest_arm.descend())."""
    return (
        "a local minimum of the distance"
        if left_m >= WITHIN_M
        else "orientation or the joints' margins outweigh the distance"
    )


def motion_cause(valley: arm.Valley) -> str:
    """Returns the reason why the arm is still moving."""
    if not valley.curvature_m2.size:
        return "every joint is at a limit and would be moved beyond it"
    least = valley.curvature_m2[0]
    if least < -FLAT_M2:
        return "near a saddle of the distance"
    if least < FLAT_M2:
        return f"a flat valley of the distance, {'at joint limits' if valley.limits else 'at a singularity'}"
    return "still moving to the target"


def geometry(valley: arm.Valley) -> str:
    limits = f"joint {' '.join(map(str, valley.limits))} at a limit" if valley.limits else "no joint at a limit"
    return (
        f"{'in' if valley.reachable else 'out of'} reach, {1e3 * valley.error_m:.2f} mm off, {limits}, "
        f"slope {1e4 * valley.slope_m2:.3f} cm2/rad, "
        f"curvature {' '.join(f'{1e4 * c:.2f}' for c in valley.curvature_m2)} cm2, "
        f"singular value {1e3 * valley.singular_m:.1f} mm/rad"
    )


def listed(numbers: Sequence[int], outcomes: np.ndarray, window: int, is_position: bool = False) -> list[dict]:
    """Returns a description of each case with one of these numbers, including why it is an exception."""
    postures, targets = outcomes["position_rad"][numbers, window], outcomes["target"][numbers, 4:]
    left_m = (
        np.linalg.norm(targets - arm.hand_m(arm.descend(postures, targets)), axis=1)
        if is_position
        else np.zeros(len(numbers))
    )
    valleys = [arm.valley(posture, target) for posture, target in zip(postures, targets, strict=True)]
    return [
        {
            "case": int(number),
            "peak_radps": round(float(outcomes["peak_radps"][number, window].max()), 4),
            "sign_changes": int(outcomes["sign_changes"][number, window].max()),
            "cause": position_cause(left) if is_position else motion_cause(valley),
            "geometry": geometry(valley),
        }
        for number, left, valley in zip(numbers, left_m, valleys, strict=True)
    ]


def print_causes(name: str, entries: list[dict]) -> None:
    for cause, count in collections.Counter(entry["cause"] for entry in entries).most_common():
        print(f"      {name}: {count} times {cause}")


# ---- requirements


@dataclasses.dataclass
class Check:
    name: str
    value: float
    limit: float  # upper limit in at_most(), lower limit in at_least()
    passed: bool


def at_most(name: str, value: float, limit: float) -> Check:
    return Check(name, value, limit, value <= limit)


def at_least(name: str, value: float, limit: float) -> Check:
    return Check(name, value, limit, value >= limit)


def rest(outcomes: np.ndarray, where: str = "rest") -> tuple[list[Check], dict]:
    early, late = judgement.EARLY, judgement.LATE
    oscillating = [judgement.oscillates(outcomes, w) for w in (early, late)]
    creeping = [judgement.creeps(outcomes, w) for w in (early, late)]
    checks = [
        at_most(
            f"{where}: not in cooperation",
            float((outcomes["interrupted"].any(axis=1) | (outcomes["start"] != ACCEPTED)).sum()),
            0,
        ),
        at_most(f"{where}: oscillating in the last 2 s of 8 s", float(oscillating[early].sum()), 0),
        at_most(
            f"{where}: share creeping in the last 2 s of 8 s",
            float(creeping[early].mean()),
            judgement.CREEPING_SHARE[early],
        ),
        at_most(f"{where}: oscillating in the last 2 s of 20 s", float(oscillating[late].sum()), 0),
        at_most(
            f"{where}: share creeping in the last 2 s of 20 s",
            float(creeping[late].mean()),
            judgement.CREEPING_SHARE[late],
        ),
    ]
    exceptions = {
        f"{where}_of_8_s": listed(np.flatnonzero(oscillating[early] | creeping[early]), outcomes, early),
        f"{where}_of_20_s": listed(np.flatnonzero(oscillating[late] | creeping[late]), outcomes, late),
    }
    return checks, exceptions


def position(outcomes: np.ndarray) -> tuple[list[Check], dict]:
    error_m = np.linalg.norm(
        outcomes["target"][:, 4:] - arm.hand_m(outcomes["position_rad"][:, judgement.EARLY]), axis=1
    )
    within = error_m < WITHIN_M
    checks = [
        at_least(
            "position: share within 1 mm where reachable, with posture_change",
            float(within.mean()),
            WITHIN_SHARE,
        )
    ]
    return checks, {"beyond_1_mm": listed(np.flatnonzero(~within), outcomes, judgement.EARLY, is_position=True)}


def pairs(verdicts: list[rest_pairs.Verdict]) -> tuple[list[Check], dict]:
    wrong = [v for v in verdicts if v.what not in ("refused", "rests") and not v.warned]
    by_what = {what: sum(v.what == what for v in verdicts) for what in sorted({v.what for v in verdicts})}
    print(
        f"pairs: {len(verdicts)}: {', '.join(f'{count} {what}' for what, count in by_what.items())}; "
        f"with a warning: {sum(v.warned for v in verdicts)}"
    )
    checks = [at_most("pairs: neither rejected, nor at rest, nor with a warning", len(wrong), 0)]
    return checks, {
        "pairs": by_what | {"of": len(verdicts)},
        "pairs_wrong": [dataclasses.asdict(v) for v in wrong],
        "pairs_warned": [dataclasses.asdict(v) for v in verdicts if v.warned],
    }


# ---- main


def parameter(text: str) -> tuple[str, float]:
    name, separator, value = text.partition("=")
    if not separator:
        raise argparse.ArgumentTypeError(f"{text!r}: expected NAME=VALUE")
    return name, float(value)


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="make rest", description="checks that the arm rests when the hand rests")
    parser.add_argument("build", type=Path)
    parser.add_argument("--seeds", choices=generated.SEEDS, default="proof")
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--reachable", type=int, default=REACHABLE)
    parser.add_argument("--ode", type=int, default=ODE)
    parser.add_argument("--pairs", type=int, default=PAIR_CASES, help="number of cases for each pair of parameters")
    parser.add_argument("--parameter", type=parameter, action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--out", type=Path)
    options = parser.parse_args(arguments)
    campaign = Campaign(options.build, options.seeds, dict(options.parameter))
    reaching = Campaign(
        options.build, options.seeds, {"posture_change": 1.0, **dict(options.parameter)}
    )  # posture_change is off by default
    checks, exceptions = [], {}
    stages = (
        (options.cases, rest, lambda: campaign.outcomes(generated.random_cases(options.seeds, range(options.cases)))),
        (
            options.reachable,
            position,
            lambda: reaching.outcomes(generated.reachable_cases(options.seeds, options.reachable)),
        ),
        (options.ode, lambda outcomes: rest(outcomes, "ode"), lambda: campaign.in_ode(options.ode)),
        (options.pairs, pairs, lambda: campaign.of_pairs(options.pairs)),
    )
    for count, judge, run in stages:
        if count > 0:
            found, listed_here = judge(run())
            checks += found
            exceptions |= listed_here
    for check in checks:
        print(f"{'pass' if check.passed else 'FAIL'}  {check.name}: {check.value:.4g}, required {check.limit:g}")
    for name, entries in exceptions.items():
        if isinstance(entries, list):
            print_causes(name, [entry for entry in entries if "cause" in entry])
    report = {
        "seeds": options.seeds, "cases": options.cases, "reachable": options.reachable, "ode": options.ode,
        "pair_cases": options.pairs,
        "parameters": campaign.parameters,
        "checks": [dataclasses.asdict(check) for check in checks], "exceptions": exceptions,
    }  # fmt: skip
    file = options.out or options.build / "reports" / "rest.json"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(report, indent=1) + "\n")
    print(f"exceptions with their causes: {file}")
    return 0 if all(check.passed for check in checks) else 1


if __name__ == "__main__":
    sys.exit(main())
