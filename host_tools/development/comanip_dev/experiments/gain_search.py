"""Searches for the gains of the paper's control law (4) and of our law (firmware/control/position_priority.h).

``python -m comanip_dev.experiments.gain_search --out DIR`` (``make gain-search``).

The simulator runs all scenarios and seeds with each candidate. The score of a run is a sum of terms, each divided by an
acceptable value:

    score = position RMS / 5 mm + orientation RMS / 20 deg + share of ticks at the acceleration limit / 10 %
            + force RMS / 5 N + 10 if a check failed

The score of a candidate is the mean over its runs. The lowest score is the best. A term that a run did not measure,
because the arm never cooperated or nothing was held, counts as 0, but a failed check still adds its 10. The score of a
run is at most WORST, which is also the score of a run without a summary. Failed checks weigh most, because gains that
fail the task are useless. Orientation has a large divisor because four joints cannot follow every orientation.

Two laws are searched on grids:

(a) the paper's law with error_frame = torso, W = 1 and K = diag(k_r x4, k_t x4), over k_r, k_t / k_r and lambda;
(b) our law with prediction, over the gain k = following_gain_per_s and the ratio 1 / orientation_weight_m2.

The search first tries a coarse grid with one seed. The order is shuffled but repeatable, so that a search cut short by
--budget-s still covers the whole range. It then tries the neighbours of the best candidates, half a grid step away, and
finally the best candidates with more seeds. It writes all candidates to tried.csv, and the best of each law, with the
share of the grid that was tried, to gains.md.
"""

from __future__ import annotations

import argparse
import csv
import io
import itertools
import math
import random
import shutil
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from comanip.plotting.run_data import RunDataError, read_trace

from comanip_dev.experiments.campaign import SIMULATOR, CampaignError, Job, Outcome, run_jobs
from comanip_dev.experiments.jobs import SCENARIOS
from comanip_dev.experiments.paper_gains import TORSO, law_parameters
from comanip_dev.experiments.program import guarded, positive_integer

POSITION_MM, ORIENTATION_DEG, ACCELERATION_SHARE, FORCE_N, FAILED = 5.0, 20.0, 0.1, 5.0, 0.1
WORST = 100.0
MAX_GAIN_PER_S = 500.0  # maximum of the firmware's parameters
ACCELERATION_RADPS2, TICK_S = 25.0, 1e-3
RATE_STEP_RADPS = 1e-3  # resolution of velocities in the trace
ROTATION_GAINS_PER_S = (0.3, 1.0, 3.0, 10.0, 30.0, 100.0)
GAIN_RATIOS = (1.0, 4.0, 16.0, 64.0, 256.0, 1024.0)
DAMPINGS = (1e-4, 1e-3, 1e-2, 1e-1)
OUR_GAINS_PER_S = (10.0, 20.0, 25.0, 35.0, 50.0, 60.0)
OUR_GAIN_RANGE_PER_S = (1.0, 60.0)  # range of the firmware's parameter
OUR_RATIOS_PER_M2 = (1e3, 1e4, 1e5, 1e6)  # 1 / orientation_weight_m2, whose maximum is 1e-3
BEST = 5  # number of best candidates whose neighbours are tried, and number of those tried with more seeds
SHOWN = 10
ORDER_SEED = 1


@dataclass(frozen=True)
class Candidate:
    """A set of gains to try. gain_per_s: k_r of the paper's law, or k of ours. ratio: k_t / k_r of the paper's law, or
    1 / orientation_weight_m2 of ours. damping: lambda of the paper's law; 0 for ours, which has no such parameter."""

    law: str  # "paper" or "ours"
    gain_per_s: float
    ratio: float
    damping: float

    @property
    def is_possible(self) -> bool:
        """True if all values are within the ranges of the firmware's parameters."""
        if self.law == "paper":
            return self.gain_per_s * self.ratio <= MAX_GAIN_PER_S
        lowest, highest = OUR_GAIN_RANGE_PER_S
        return lowest <= self.gain_per_s <= highest and self.ratio >= OUR_RATIOS_PER_M2[0]

    @property
    def parameters(self) -> tuple[tuple[str, float], ...]:
        if self.law == "paper":
            return law_parameters(TORSO, self.gain_per_s, self.gain_per_s * self.ratio, 1.0, 1.0, self.damping)
        return (
            ("prediction", 1.0),
            ("following_gain_per_s", self.gain_per_s),
            ("orientation_weight_m2", 1 / self.ratio),
        )


@dataclass(frozen=True)
class Score:
    """The score of a candidate and the means of its terms. A term that no run measured is NaN."""

    score: float
    position_mm: float
    orientation_deg: float
    acceleration_share: float
    force_N: float
    passed: int
    runs: int


@dataclass(frozen=True)
class Tried:
    stage: str
    candidate: Candidate
    score: Score


# ---- the score of one run


def acceleration_share(trace: dict[str, np.ndarray]) -> float:
    """Returns the share of the commanded ticks in which a joint accelerates at its limit."""
    rates = np.stack([trace[f"dq{i}_command_radps"] for i in range(4)], axis=1)
    change = np.abs(np.diff(rates, axis=0))
    change = change[np.isfinite(change).all(axis=1)]
    if not len(change):
        return math.nan
    return float(np.mean(change.max(axis=1) >= ACCELERATION_RADPS2 * TICK_S - RATE_STEP_RADPS - 1e-9))


def figures(outcome: Outcome) -> tuple[float, float, float, float, float]:
    """Returns the terms of a run: position [mm], orientation [deg], share at the acceleration limit, force [N], and 1
    if the run failed."""
    tracking = outcome.summary.get("tracking") or {}
    forces = [p.get("force_rms_N") for p in outcome.summary.get("people") or []]
    forces = [force for force in forces if force is not None]
    try:
        share = acceleration_share(read_trace(outcome.job.out / "trace.csv"))
    except RunDataError:
        share = math.nan
    known = [tracking.get(key) for key in ("rms_position_mm", "rms_orientation_deg")]
    position, orientation = (math.nan if value is None else value for value in known)
    return position, orientation, share, max(forces, default=math.nan), 0.0 if outcome.passed else 1.0


def run_score(values: tuple[float, float, float, float, float]) -> float:
    parts = zip(values, (POSITION_MM, ORIENTATION_DEG, ACCELERATION_SHARE, FORCE_N, FAILED), strict=True)
    return min(WORST, sum(value / acceptable for value, acceptable in parts if math.isfinite(value)))


def _mean(values: Iterable[float]) -> float:
    finite = [value for value in values if math.isfinite(value)]
    return sum(finite) / len(finite) if finite else math.nan


def score(outcomes: Sequence[Outcome]) -> Score:
    measured = [figures(o) for o in outcomes if o.summary]
    scores = [run_score(values) for values in measured] + [WORST] * (len(outcomes) - len(measured))
    columns = [_mean(values[k] for values in measured) for k in range(4)]
    return Score(_mean(scores), *columns, sum(o.passed for o in outcomes), len(outcomes))


# ---- candidates


def coarse_grid(law: str) -> list[Candidate]:
    paper, ours = (ROTATION_GAINS_PER_S, GAIN_RATIOS, DAMPINGS), (OUR_GAINS_PER_S, OUR_RATIOS_PER_M2, (0.0,))
    grid = [Candidate(law, *point) for point in itertools.product(*(paper if law == "paper" else ours))]
    possible = [candidate for candidate in grid if candidate.is_possible]
    random.Random(ORDER_SEED).shuffle(possible)
    return possible


def neighbours(candidate: Candidate) -> list[Candidate]:
    """Returns the candidates that differ from this one in a single value, by about half a step of the coarse grid."""
    steps = (("gain_per_s", 1.4), ("ratio", 2.0), ("damping", 3.0))
    found = []
    for name, factor in steps:
        for scale in (1.0 / factor, factor):
            values = {**vars(candidate), name: float(f"{getattr(candidate, name) * scale:.3g}")}
            found.append(Candidate(**values))
    return [neighbour for neighbour in found if neighbour.is_possible]


def best_of(tried: Iterable[Tried], count: int) -> list[Candidate]:
    return [t.candidate for t in sorted(tried, key=lambda t: t.score.score)[:count]]


class Search:
    """Tries candidates until the time is up. tried: candidates with their scores."""

    def __init__(self, run: Callable[[Candidate, int], Score], budget_s: float) -> None:
        self._run = run
        self._end_s = time.monotonic() + budget_s
        self.tried: list[Tried] = []

    def stage(self, name: str, candidates: Sequence[Candidate], seeds: int, share_end_s: float) -> list[Tried]:
        """Tries these candidates until share_end_s, but at least the first one, so that there is a result."""
        done: list[Tried] = []
        for candidate in candidates:
            if done and time.monotonic() > share_end_s:
                break
            done.append(Tried(name, candidate, self._run(candidate, seeds)))
            self.tried.append(done[-1])
            found = done[-1].score
            print(
                f"{candidate.law} {name} {len(done)}/{len(candidates)}: gain {candidate.gain_per_s:g}/s, ratio "
                f"{candidate.ratio:g}, lambda {candidate.damping:g}: score {found.score:.2f}, passed "
                f"{found.passed}/{found.runs}",
                flush=True,
            )
        return done

    def law(self, law: str, seeds: int, end_s: float) -> None:
        """Searches for the gains of one law until end_s. Half of the time is for the coarse grid, a quarter for
        refining, and a quarter for confirming with more seeds."""
        begin_s = time.monotonic()
        span_s = max(0.0, min(end_s, self._end_s) - begin_s)
        coarse = self.stage("coarse", coarse_grid(law), 1, begin_s + 0.5 * span_s)
        known = {t.candidate for t in coarse}
        near = [n for best in best_of(coarse, BEST) for n in neighbours(best)]
        fresh = [n for n in dict.fromkeys(near) if n not in known]
        refined = self.stage("refined", fresh, 1, begin_s + 0.75 * span_s)
        self.stage("confirmed", best_of([*coarse, *refined], BEST), seeds, begin_s + span_s)


# ---- results


COLUMNS = ("law", "stage", "gain_per_s", "ratio", "damping", "score", "position_rms_mm", "orientation_rms_deg")
COLUMNS += ("acceleration_limit_share", "force_rms_N", "passed", "runs")


def row(t: Tried) -> tuple:
    c, s = t.candidate, t.score
    measured = (s.score, s.position_mm, s.orientation_deg, s.acceleration_share, s.force_N)
    return (c.law, t.stage, c.gain_per_s, c.ratio, c.damping, *(f"{value:.4g}" for value in measured), s.passed, s.runs)


def csv_text(tried: Sequence[Tried]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows(row(t) for t in tried)
    return out.getvalue()


def markdown(tried: Sequence[Tried], scenarios: Sequence[str]) -> str:
    """Returns the text of gains.md with the best candidates of each law. Those confirmed with more seeds come first."""
    names = ", ".join(scenarios)
    lines = [
        "# Gains found",
        "",
        f"Scenarios: {names}. Score and grid: host_tools/development/comanip_dev/experiments/gain_search.py.",
    ]
    for law, what in (("paper", "gain = k_r, ratio = k_t / k_r"), ("ours", "gain = k, ratio = 1 / w [1/m^2]")):
        of_law = [t for t in tried if t.candidate.law == law]
        if not of_law:
            continue
        seen = sum(t.stage == "coarse" for t in of_law)
        ranked = sorted(of_law, key=lambda t: (t.stage != "confirmed", t.score.score))[:SHOWN]
        share = f"{seen} of {len(coarse_grid(law))} points of the coarse grid tried."
        lines += ["", f"## {law}: {what}", "", share, ""]
        lines += ["| " + " | ".join(COLUMNS[1:]) + " |", "|---" * (len(COLUMNS) - 1) + "|"]
        lines += ["| " + " | ".join(str(cell) for cell in row(t)[1:]) + " |" for t in ranked]
    return "\n".join(lines) + "\n"


def run_search(arguments: argparse.Namespace) -> int:
    out: Path = arguments.out
    scratch = out / "runs"
    out.mkdir(parents=True, exist_ok=True)

    def run(candidate: Candidate, seeds: int) -> Score:
        jobs = [
            Job(name, seed, scratch / f"{name}-{seed:02d}", parameters=candidate.parameters)
            for name in arguments.scenarios
            for seed in range(1, seeds + 1)
        ]
        for job in jobs:
            (job.out / "trace.csv").unlink(missing_ok=True)  # remove the previous candidate's trace
        outcomes = run_jobs(jobs, arguments.simulator, arguments.jobs)
        if not search.tried and not any(o.summary for o in outcomes):
            raise CampaignError(f"no run could be scored: {outcomes[0].job.label}: {outcomes[0].reason}")
        return score(outcomes)

    search = Search(run, arguments.budget_s)
    begin_s = time.monotonic()
    for k, law in enumerate(arguments.laws):
        search.law(law, arguments.seeds, begin_s + arguments.budget_s * (k + 1) / len(arguments.laws))
    shutil.rmtree(scratch, ignore_errors=True)
    (out / "tried.csv").write_text(csv_text(search.tried))
    (out / "gains.md").write_text(markdown(search.tried, arguments.scenarios))
    print(f"wrote {out / 'tried.csv'}, {out / 'gains.md'}")
    return 0


def positive_number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0.0):
        raise argparse.ArgumentTypeError(f"{text!r}: expected a number above 0")
    return value


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="comanip_dev.experiments.gain_search", description="Searches for the gains of both control laws."
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for tried.csv and gains.md")
    parser.add_argument(
        "--budget-s", type=positive_number, default=3600.0, help="approximate limit of wall time in s (default 3600)"
    )
    parser.add_argument("--seeds", type=positive_integer, default=5, help="seeds of the confirming runs (default 5)")
    parser.add_argument(
        "--scenarios", nargs="+", choices=SCENARIOS, default=list(SCENARIOS), help="scenarios to run (default: all)"
    )
    parser.add_argument(
        "--laws", nargs="+", choices=("paper", "ours"), default=["paper", "ours"], help="laws to search (default: both)"
    )
    parser.add_argument("--jobs", type=positive_integer, default=2, help="parallel simulators (default 2)")
    parser.add_argument("--simulator", type=Path, default=SIMULATOR, help="the simulator to run")
    arguments = parser.parse_args(argv)
    return guarded("comanip_dev.experiments.gain_search", lambda: run_search(arguments))


if __name__ == "__main__":
    sys.exit(main())
