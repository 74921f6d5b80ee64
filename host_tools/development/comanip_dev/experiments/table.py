"""Builds the table of the experiments, with the number of passed runs and the decisive figures."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from rich.table import Table
from rich.text import Text

from comanip_dev.experiments.campaign import Outcome
from comanip_dev.experiments.jobs import SCENARIOS
from comanip_dev.experiments.judgement import CAUGHT_TOGETHER_MIN_PERCENT, Condition, pouring_conditions, shown


@dataclass(frozen=True)
class Figure:
    """A check whose value is shown. higher_is_better: True if the lowest value is the worst."""

    check: str
    higher_is_better: bool

    def worst(self, values: Sequence[float]) -> float:
        return min(values) if self.higher_is_better else max(values)


DECISIVE = {
    "pour": (Figure("glass_tilt", True), Figure("water_poured", True), Figure("water_caught", True)),
    "teleop": (Figure("pipe_with_taker", True), Figure("pipe_drops", False)),
    "mirror": (
        Figure("mirrored_back", False),
        Figure("same_side", False),
        Figure("same_height", False),
        Figure("carried_for", True),
        Figure("force_rms", False),
        Figure("force_peak", False),
        Figure("relation", False),
        Figure("following", False),
    ),
    "handover": (Figure("baton_with_person", True), Figure("baton_drops", False)),
    "crank": (Figure("turns", True), Figure("force_rms", False)),
}


def figure_lines(outcomes: Sequence[Outcome], figures: Sequence[Figure]) -> list[tuple[str, str, str, str]]:
    """Returns (name with unit, median, worst value, limit) for each figure. The median and the worst value are taken
    over the runs that measured the figure, and are "-" if no run measured it."""
    lines = []
    for figure in figures:
        found = [check for o in outcomes for check in o.checks if check["name"] == figure.check]
        values = [check["value"] for check in found if check["value"] is not None]
        unit = f" [{found[0]['unit']}]" if found and found[0]["unit"] else ""
        missing = f" ({len(outcomes) - len(values)} not measured)" if len(values) < len(outcomes) else ""
        limit = f"{'>=' if figure.higher_is_better else '<='} {found[0]['limit']:g}" if found else "-"
        median = statistics.median(values) if values else None
        worst = figure.worst(values) if values else None
        lines.append((figure.check + unit + missing, shown(median), shown(worst), limit))
    return lines


def condition_lines(conditions: Sequence[Condition]) -> list[tuple[str, str, str, str]]:
    """Returns a line like those of figure_lines(), for the share of caught particles in each condition."""
    if not conditions:
        return []
    values = [c.caught_percent for c in conditions if c.caught_percent is not None]
    median, worst = (statistics.median(values), min(values)) if values else (None, None)
    return [("water_caught, seeds together [%]", shown(median), shown(worst), f">= {CAUGHT_TOGETHER_MIN_PERCENT:g}")]


def _table_row(table: Table, title: str, outcomes: Sequence[Outcome], figures: Sequence[Figure]) -> None:
    passed = sum(o.passed for o in outcomes)
    conditions = pouring_conditions(outcomes)
    columns = zip(*figure_lines(outcomes, figures), *condition_lines(conditions), strict=True)
    style = "green" if passed == len(outcomes) and all(c.passed for c in conditions) else "red"
    table.add_row(title, Text(f"{passed}/{len(outcomes)}", style), *(Text("\n".join(column)) for column in columns))


def results_table(outcomes: Sequence[Outcome], recordings_missing: str | None) -> Table:
    table = Table(title="Experiments", caption=recordings_missing)
    for heading in ("scenario", "passed", "figure", "median", "worst", "limit"):
        justify = "right" if heading in ("passed", "median", "worst") else "left"
        table.add_column(heading, justify=justify, no_wrap=True)
    for name in SCENARIOS:
        for title, is_recorded in ((name, False), (f"{name}, recordings", True)):
            part = [o for o in outcomes if o.job.scenario == name and (o.job.recording is not None) == is_recorded]
            if part:
                _table_row(table, title, part, DECISIVE[name])
                table.add_section()
    return table
