"""``make rest``: when the hand rests, the arm comes to rest, with position first.

``rest.py BUILD [--seeds choice|proof] [--cases N] [--reachable N] [--parameter NAME=VALUE ...] [--out FILE]``. Random cases (rest_cases.py) go
through the firmware's own controller_step() in a loop with drives (loop.c), for 20 s each:

    rest      in the last 2 s of 8 s no case swings, at most 1.5 % creep, and in the last 2 s of 20 s at most 0.2 % do (rest_judgement.py)
    position  of cases whose target's position can be reached (rest_arm.py), 95 % have it within 1 mm after 8 s

Each exception is listed with what the arm's own geometry says of where it ended. Outcomes are kept in BUILD/rest by the firmware's fingerprint: a
campaign that was stopped goes on where it was. Prints the figures and writes FILE. Exit status 1 if something asked for is missed.
"""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

import rest_arm as arm  # noqa: E402
import rest_cases as generated  # noqa: E402
import rest_judgement as judgement  # noqa: E402
from rest_loop import ACCEPTED, OUTCOME, Loop  # noqa: E402

CASES, REACHABLE = 5000, 2000
BATCH = 250  # cases that are kept at once
WITHIN_M, WITHIN_SHARE = 1e-3, 0.95


class Campaign:
    """Outcomes of cases, run or taken from what is kept."""

    def __init__(self, build: Path, seeds: str, parameters: dict[str, float]) -> None:
        self.loop = Loop(build)
        self.seeds, self.parameters = seeds, parameters
        self._folder = build / "rest" / "outcomes"
        self._folder.mkdir(parents=True, exist_ok=True)

    def outcomes(self, cases: np.ndarray) -> np.ndarray:
        parts = [self._batch(cases[first : first + BATCH]) for first in range(0, len(cases), BATCH)]
        return np.concatenate(parts) if parts else np.zeros(0, OUTCOME)

    def _batch(self, cases: np.ndarray) -> np.ndarray:
        what = json.dumps([self.loop.fingerprint, sorted(self.parameters.items())]).encode() + cases.tobytes()
        file = self._folder / f"{hashlib.sha256(what).hexdigest()[:24]}.npy"
        if file.exists():
            return np.load(file)
        outcomes = self.loop.run(cases, self.parameters)
        unfinished = file.with_suffix(".part")
        with unfinished.open("wb") as stream:
            np.save(stream, outcomes)
        unfinished.replace(file)
        return outcomes


# ---- why


def cause(posture_rad: np.ndarray, target_m: np.ndarray) -> str:
    """What the arm's geometry says of a posture and a target, in a few words."""
    valley = arm.valley(posture_rad, target_m)
    ends = f"joint {' '.join(map(str, valley.ends))} at an end" if valley.ends else "no joint at an end"
    return (
        f"{'in' if valley.reachable else 'out of'} reach, {1e3 * valley.error_m:.2f} mm off, {ends}, slope {1e4 * valley.slope_m2:.3f} cm2/rad, "
        f"curvature {' '.join(f'{1e4 * c:.2f}' for c in valley.curvature_m2)} cm2, singular value {1e3 * valley.singular_m:.1f} mm/rad"
    )


def listed(numbers: Sequence[int], outcomes: np.ndarray, window: int) -> list[dict]:
    return [
        {
            "case": int(number),
            "peak_radps": round(float(outcomes["peak_radps"][number, window].max()), 4),
            "sign_changes": int(outcomes["sign_changes"][number, window].max()),
            "cause": cause(outcomes["position_rad"][number, window], outcomes["target"][number, 4:]),
        }
        for number in numbers
    ]


# ---- what is asked


@dataclasses.dataclass
class Check:
    name: str
    value: float
    limit: float  # at most; of a share that is within, at least
    passed: bool


def at_most(name: str, value: float, limit: float) -> Check:
    return Check(name, value, limit, value <= limit)


def at_least(name: str, value: float, limit: float) -> Check:
    return Check(name, value, limit, value >= limit)


def rest(outcomes: np.ndarray) -> tuple[list[Check], dict]:
    early, late = judgement.EARLY, judgement.LATE
    swinging = [judgement.swings(outcomes, w) for w in (early, late)]
    creeping = [judgement.creeps(outcomes, w) for w in (early, late)]
    checks = [
        at_most("rest: not in cooperation", float((outcomes["interrupted"].any(axis=1) | (outcomes["start"] != ACCEPTED)).sum()), 0),
        at_most("rest: swinging in the last 2 s of 8 s", float(swinging[early].sum()), 0),
        at_most("rest: share creeping in the last 2 s of 8 s", float(creeping[early].mean()), judgement.CREEPING_SHARE[early]),
        at_most("rest: swinging in the last 2 s of 20 s", float(swinging[late].sum()), 0),
        at_most("rest: share creeping in the last 2 s of 20 s", float(creeping[late].mean()), judgement.CREEPING_SHARE[late]),
    ]
    exceptions = {
        "of_8_s": listed(np.flatnonzero(swinging[early] | creeping[early]), outcomes, early),
        "of_20_s": listed(np.flatnonzero(swinging[late] | creeping[late]), outcomes, late),
    }
    return checks, exceptions


def position(outcomes: np.ndarray) -> tuple[list[Check], dict]:
    error_m = np.linalg.norm(outcomes["target"][:, 4:] - arm.hand_m(outcomes["position_rad"][:, judgement.EARLY]), axis=1)
    within = error_m < WITHIN_M
    checks = [at_least("position: share within 1 mm where it can be reached", float(within.mean()), WITHIN_SHARE)]
    return checks, {"beyond_1_mm": listed(np.flatnonzero(~within), outcomes, judgement.EARLY)}


# ---- main


def parameter(text: str) -> tuple[str, float]:
    name, separator, value = text.partition("=")
    if not separator:
        raise argparse.ArgumentTypeError(f"{text!r}: expected NAME=VALUE")
    return name, float(value)


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="make rest", description="when the hand rests, the arm comes to rest")
    parser.add_argument("build", type=Path)
    parser.add_argument("--seeds", choices=generated.SEEDS, default="proof")
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--reachable", type=int, default=REACHABLE)
    parser.add_argument("--parameter", type=parameter, action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--out", type=Path)
    options = parser.parse_args(arguments)
    campaign = Campaign(options.build, options.seeds, dict(options.parameter))
    checks, exceptions = [], {}
    stages = (
        (rest, lambda: generated.random_cases(options.seeds, range(options.cases))),
        (position, lambda: generated.reachable_cases(options.seeds, options.reachable)),
    )
    for judge, make in stages:
        made = make()
        if len(made):
            found, listed_here = judge(campaign.outcomes(made))
            checks += found
            exceptions |= listed_here
    for check in checks:
        print(f"{'pass' if check.passed else 'FAIL'}  {check.name}: {check.value:.4g}, asked {check.limit:g}")
    report = {
        "seeds": options.seeds, "cases": options.cases, "reachable": options.reachable, "parameters": campaign.parameters,
        "checks": [dataclasses.asdict(check) for check in checks], "exceptions": exceptions,
    }  # fmt: skip
    file = options.out or options.build / "reports" / "rest.json"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(report, indent=1) + "\n")
    print(f"exceptions with their causes: {file}")
    return 0 if all(check.passed for check in checks) else 1


if __name__ == "__main__":
    sys.exit(main())
