"""Records the result of each run, and judges all seeds of a condition together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from comanip_dev.experiments.campaign import Outcome

# Required share of caught particles among those that left the robot's glass, over all seeds of a condition.
CAUGHT_TOGETHER_MIN_PERCENT = 95.0


def shown(value: float | None) -> str:
    """Formats a value with four digits, or as a dash if it was not measured."""
    return "-" if value is None else f"{value:.4g}"


def record(outcome: Outcome) -> dict:
    """Returns the entry for this run in experiments.json."""
    job = outcome.job
    return {
        "scenario": job.scenario,
        "seed": job.seed,
        "recording": job.recording.name if job.recording else None,
        "result": outcome.result,
        "reason": outcome.reason,
        "checks": outcome.checks,
    }


@dataclass(frozen=True)
class Condition:
    """All runs of a scenario with the same motion, built-in or recorded, but different seeds. The runs are judged
    together, because in a single run of `pour` only about 60 of 160 particles leave the glass. The permitted loss of
    5 % would then be three particles, so the verdict on a single run would depend on chance."""

    scenario: str
    recording: str | None
    outcomes: tuple[Outcome, ...]

    @property
    def label(self) -> str:
        played = f", {self.recording}" if self.recording else ""
        return f"{self.scenario}{played}, {len(self.outcomes)} seeds together"

    def _particles(self, key: str) -> int:
        return sum((o.summary.get("water") or {}).get(key, 0) for o in self.outcomes)

    @property
    def poured(self) -> int:
        return self._particles("poured")

    @property
    def caught(self) -> int:
        return self._particles("in_person_cup")

    @property
    def caught_percent(self) -> float | None:
        return 100.0 * self.caught / self.poured if self.poured else None

    @property
    def passed(self) -> bool:
        return self.caught_percent is not None and self.caught_percent >= CAUGHT_TOGETHER_MIN_PERCENT

    @property
    def reason(self) -> str:
        """One line that states why the condition failed."""
        return (
            f"{self.caught} of {self.poured} particles caught ({shown(self.caught_percent)} %), "
            f"expected at least {CAUGHT_TOGETHER_MIN_PERCENT:g} %"
        )

    def record(self) -> dict:
        """Returns the entry for this condition in conditions.json."""
        return {
            "scenario": self.scenario,
            "recording": self.recording,
            "runs": len(self.outcomes),
            "poured": self.poured,
            "caught": self.caught,
            "caught_percent": self.caught_percent,
            "limit_percent": CAUGHT_TOGETHER_MIN_PERCENT,
            "pass": self.passed,
        }


def pouring_conditions(outcomes: Sequence[Outcome]) -> list[Condition]:
    found: dict[str | None, list[Outcome]] = {}
    for outcome in outcomes:
        if outcome.job.scenario == "pour":
            found.setdefault(outcome.job.recording.name if outcome.job.recording else None, []).append(outcome)
    return [Condition("pour", recording, tuple(part)) for recording, part in found.items()]
