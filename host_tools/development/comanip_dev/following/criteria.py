"""Defines the criteria that the default control law must meet on each half of the recordings. Most criteria compare the
law with the former default, which is the law without prediction. A criterion that was not measured counts as failed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from comanip_dev.following import plan
from comanip_dev.following.plan import Condition, Setting
from comanip_dev.following.results import Results, case_key

RMS_RATIO = {plan.FAST: 0.25, plan.MIDDLE: 0.30, plan.SLOW: 0.55}
DELAY_MS = {plan.FAST: 5.0, plan.MIDDLE: 5.0, plan.SLOW: 12.0}
MORE_NOISE_UM = {plan.FAST: 20.0, plan.MIDDLE: 20.0, plan.SLOW: 0.0}
MAX_RATIO = 0.45
ACCELERATION_RATIO = 1.1
TURNING_RATIO, TAKER_RMS_MM, TAKER_MAX_MM = 0.25, 2.0, 10.0
OTHER_TASKS_RATIO = 0.35
WRONG_NOISE_RATIO = 1.1  # a wrong announced latency must not cause oscillations of the arm


@dataclass(frozen=True)
class Criterion:
    """A measured value with its upper limit. value: NaN if it was not measured."""

    loop: str
    what: str
    value: float
    limit: float
    unit: str = ""

    @property
    def passed(self) -> bool:
        return self.value <= self.limit  # False if the value is NaN


class Judge:
    """Evaluates results. scenes: for each setting, the names of the recordings that the arm can follow."""

    def __init__(self, results: Results, scenes: dict[Setting, Sequence[str]]) -> None:
        self._results = results
        self._scenes = scenes

    def figure(
        self, loop: str, follower: str, condition: Condition, setting: Setting, name: str | None, figure: str
    ) -> float:
        """Returns the mean of a figure over the seeds of the tracker's noise. name: recording; None if the hand is at
        rest."""
        seeds = plan.seeds(follower, condition) if name else (1,)
        keys = [case_key(loop, follower, condition, setting, name, seed) for seed in seeds]
        found = [self._results.values.get(key, {}).get(figure, math.nan) for key in keys]
        return sum(found) / len(found)

    def ratio(self, loop: str, condition: Condition, setting: Setting, name: str | None, figure: str) -> float:
        """Returns a figure of the default law divided by the same figure of the former default law."""
        former = self.figure(loop, plan.FORMER, condition, setting, name, figure)
        return self.figure(loop, plan.DEFAULT, condition, setting, name, figure) / former if former else math.nan

    def folds(self, setting: Setting) -> tuple[tuple[str, ...], tuple[str, ...]]:
        return plan.folds(self._scenes[setting])

    def _in_folds(
        self, loop: str, what: str, setting: Setting, limit: float, one: Callable[[str], float], unit: str = "",
        without: Sequence[str] = (),
    ) -> list[Criterion]:  # fmt: skip
        """Returns a criterion for each fold, which is one half of the recordings. The value of the criterion is the
        mean of one(name) over the recordings in the fold, except those in `without`."""
        found = []
        for number, fold in enumerate(self.folds(setting), 1):
            values = [one(name) for name in fold if name not in without]
            mean = sum(values) / len(values) if values else math.nan
            found.append(Criterion(loop, f"{setting.label}: {what}, half {number}", mean, limit, unit))
        return found

    def _teleop(self, loop: str, condition: Condition) -> list[Criterion]:
        def ratio_of(figure: str) -> Callable[[str], float]:
            return lambda name: self.ratio(loop, condition, plan.TELEOP, name, figure)

        def delay(name: str) -> float:
            return abs(self.figure(loop, plan.DEFAULT, condition, plan.TELEOP, name, "delay_ms"))

        at = f"at {condition.label}"
        noise, former_noise = (
            self.figure(loop, follower, condition, plan.TELEOP, None, "noise_um")
            for follower in (plan.DEFAULT, plan.FORMER)
        )
        return [
            *self._in_folds(loop, f"RMS ratio {at}", plan.TELEOP, RMS_RATIO[condition], ratio_of("rms_mm")),
            *self._in_folds(loop, f"delay {at}", plan.TELEOP, DELAY_MS[condition], delay, "ms"),
            *self._in_folds(loop, f"largest error's ratio {at}", plan.TELEOP, MAX_RATIO, ratio_of("max_mm")),
            *self._in_folds(
                loop, f"acceleration ratio {at}", plan.TELEOP, ACCELERATION_RATIO, ratio_of("acceleration_mps2")
            ),
            Criterion(loop, f"noise at rest {at}", noise, former_noise + MORE_NOISE_UM[condition], "um"),
        ]

    def _turning(self, loop: str) -> list[Criterion]:
        setting = plan.TURNING

        def ratio(name: str) -> float:
            return self.ratio(loop, plan.FAST, setting, name, "rms_mm")

        taker = [
            self.figure(loop, plan.DEFAULT, plan.FAST, setting, plan.TAKER, figure) for figure in ("rms_mm", "max_mm")
        ]
        return [
            *self._in_folds(loop, "RMS ratio", setting, TURNING_RATIO, ratio),
            *self._in_folds(
                loop, "RMS ratio without those that lock", setting, TURNING_RATIO, ratio, without=plan.LOCKING
            ),
            Criterion(loop, f"{setting.label}: RMS of {plan.TAKER}", taker[0], TAKER_RMS_MM, "mm"),
            Criterion(loop, f"{setting.label}: largest error of {plan.TAKER}", taker[1], TAKER_MAX_MM, "mm"),
        ]

    def _other_tasks(self, loop: str) -> list[Criterion]:
        found = []
        for setting in (plan.MIRROR, plan.POUR):
            found += self._in_folds(
                loop, "RMS ratio", setting, OTHER_TASKS_RATIO,
                lambda name, setting=setting: self.ratio(loop, plan.FAST, setting, name, "rms_mm"),
            )  # fmt: skip
        return found

    def wrong_latency(self) -> list[Criterion]:
        """Returns the criteria for the noise at rest when the tracker announces a wrong latency. While the hand rests,
        a wrong latency can increase the noise only through an oscillation of the arm."""
        found = []
        for condition in plan.WRONG:
            right = Condition(condition.rate_hz, condition.latency_ms, condition.noise_mm)
            wrong_um, right_um = (
                self.figure(plan.LOOP, plan.DEFAULT, c, plan.TELEOP, None, "noise_um") for c in (condition, right)
            )
            what = f"noise at rest at {condition.label}"
            found.append(Criterion(plan.LOOP, what, wrong_um, WRONG_NOISE_RATIO * right_um, "um"))
        return found

    def criteria(self, loop: str) -> list[Criterion]:
        teleop = [c for condition in plan.JUDGED for c in self._teleop(loop, condition)]
        return [*teleop, *self._turning(loop), *self._other_tasks(loop)]


def tuned(judge: Judge, peer: str, condition: Condition, figure: str) -> tuple[float, list[str]]:
    """Returns the mean of a figure over all recordings, and the names of the tuned peers for the two halves of the
    recordings. On each half, the peer has the tuning values with the smallest mean RMS error on the other half."""
    halves, total, count, chosen = judge.folds(plan.TELEOP), 0.0, 0, []
    names = [plan.peer_name(peer, values) for values in plan.PEERS[peer]]

    def mean_rms(name: str, fold: Sequence[str]) -> float:
        values = [judge.figure(plan.LOOP, name, condition, plan.TELEOP, recording, "rms_mm") for recording in fold]
        return sum(values) / len(values) if values else math.nan

    for judged, other in (halves, halves[::-1]):
        best = min(names, key=lambda name: _nan_last(mean_rms(name, other)))
        chosen.append(best)
        for recording in judged if figure != "noise_um" else (None,):
            total += judge.figure(plan.LOOP, best, condition, plan.TELEOP, recording, figure)
            count += 1
    return (total / count if count else math.nan), chosen


def _nan_last(value: float) -> float:
    return math.inf if math.isnan(value) else value
