"""Formats the results of a campaign as tables and as JSON."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from rich.table import Table
from rich.text import Text

from comanip_dev.following import plan
from comanip_dev.following.criteria import Criterion, Judge, tuned
from comanip_dev.following.plan import Condition, Setting
from comanip_dev.following.results import Results

FIGURES = ("rms_mm", "max_mm", "rms_deg", "delay_ms", "acceleration_mps2", "limit_percent")
HEADINGS = ("RMS mm", "max mm", "RMS deg", "delay ms", "m/s2", "% lim.", "rest um")


def row(judge: Judge, loop: str, follower: str, condition: Condition, setting: Setting) -> dict[str, float]:
    """Returns the mean of each figure over the recordings of the setting, and the noise at rest. Leaves out recordings
    for which the figure is NaN."""
    names = [name for fold in judge.folds(setting) for name in fold]
    means = {}
    for figure in FIGURES:
        values = [judge.figure(loop, follower, condition, setting, name, figure) for name in names]
        known = [value for value in values if not math.isnan(value)]
        means[figure] = sum(known) / len(known) if known else math.nan
    means["noise_um"] = judge.figure(loop, follower, condition, setting, None, "noise_um")
    return means


def rows(judge: Judge, conditions: Sequence[Condition], has_peers: bool) -> list[dict]:
    """Returns all rows of the table, each with loop, setting, condition, follower and the means."""
    groups = [(plan.LOOP, plan.TELEOP, condition, plan.FIRMWARE) for condition in conditions]
    groups += [(plan.LOOP, setting, plan.FAST, plan.FIRMWARE) for setting in plan.SETTINGS[1:]]
    ode = (plan.FORMER, plan.DEFAULT)
    groups += [(plan.ODE, plan.TELEOP, condition, ode) for condition in plan.JUDGED]
    groups += [(plan.ODE, setting, plan.FAST, ode) for setting in plan.SETTINGS[1:]]
    table = []
    for loop, setting, condition, followers in groups:
        group = {"loop": loop, "setting": setting.label, "condition": condition.label}
        table += [{**group, "follower": f, **row(judge, loop, f, condition, setting)} for f in followers]
        if has_peers and loop == plan.LOOP and setting == plan.TELEOP and condition in plan.JUDGED:
            for peer in plan.PEERS:
                means = {figure: tuned(judge, peer, condition, figure)[0] for figure in (*FIGURES, "noise_um")}
                values = tuned(judge, peer, condition, "rms_mm")[1]
                table.append({**group, "follower": peer, "values": values, **means})
    return table


def _shown(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.3g}" if abs(value) < 100 else f"{value:.0f}"


def table(entries: Sequence[dict]) -> Table:
    shown = Table(title="Following: means over the recordings")
    for heading in ("condition", "follower"):
        shown.add_column(heading, no_wrap=True)
    for heading in HEADINGS:
        shown.add_column(heading, justify="right", no_wrap=True)
    last = None
    for entry in entries:
        group = f"{entry['loop']}, {entry['setting']}\n{entry['condition']}"
        if last is not None and group != last:
            shown.add_section()
        cells = (_shown(entry[figure]) for figure in (*FIGURES, "noise_um"))
        shown.add_row(group if group != last else "", entry["follower"], *cells)
        last = group
    return shown


def criteria_table(criteria: Sequence[Criterion]) -> Table:
    shown = Table(title="Criteria: the default compared with the former default")
    for heading, justify in (
        ("loop", "left"),
        ("criterion", "left"),
        ("value", "right"),
        ("at most", "right"),
        ("", "left"),
    ):
        shown.add_column(heading, justify=justify, no_wrap=True)
    for c in criteria:
        verdict = Text("pass", "green") if c.passed else Text("not measured" if math.isnan(c.value) else "FAIL", "red")
        shown.add_row(c.loop, c.what, _shown(c.value), f"{_shown(c.limit)} {c.unit}".rstrip(), verdict)
    return shown


def without_nan(value):
    """Returns the value with NaN replaced by None, because JSON has no NaN."""
    if isinstance(value, dict):
        return {key: without_nan(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [without_nan(item) for item in value]
    return None if isinstance(value, float) and math.isnan(value) else value


def wrong_latency_lines(judge: Judge) -> list[str]:
    """Returns a line per condition that shows how a wrong announced latency affects the default law."""
    lines = []
    for condition in plan.WRONG:
        right, wrong = (
            row(judge, plan.LOOP, plan.DEFAULT, c, plan.TELEOP)
            for c in (replace(condition, announced_error_ms=0.0), condition)
        )
        lines.append(
            f"{condition.label}: RMS {_shown(right['rms_mm'])} -> {_shown(wrong['rms_mm'])} mm, delay "
            f"{_shown(right['delay_ms'])} -> {_shown(wrong['delay_ms'])} ms"
        )
    return lines


def cases(results: Results) -> list[dict]:
    """Returns all cases with their figures."""
    names = ("loop", "follower", "condition", "setting", "recording", "seed")
    return [
        {**dict(zip(names, key[1:], strict=True)), **value}
        for key, value in sorted(results.values.items())
        if key[0] == "case"
    ]


def document(
    entries: Sequence[dict], criteria: Sequence[Criterion], scenes: dict, left_out: dict, single: Sequence[dict]
) -> dict:
    judged = [{**vars(c), "passed": c.passed} for c in criteria]
    return without_nan(
        {"rows": list(entries), "criteria": judged, "scenes": scenes, "left_out": left_out, "cases": list(single)}
    )
