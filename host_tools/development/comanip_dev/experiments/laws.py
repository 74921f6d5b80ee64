"""Compares our control law with the paper's over the same seeds."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence

from comanip_dev.experiments.campaign import Outcome
from comanip_dev.experiments.jobs import SCENARIOS
from comanip_dev.experiments.judgement import shown
from comanip_dev.experiments.paper_gains import PAPER_GAINS


def _median(outcomes: Sequence[Outcome], read: Callable[[dict], float | None]) -> float | None:
    values = [value for o in outcomes if (value := read(o.summary)) is not None]
    return statistics.median(values) if values else None


def _tracking(key: str) -> Callable[[dict], float | None]:
    return lambda summary: (summary.get("tracking") or {}).get(key)


def _force(key: str) -> Callable[[dict], float | None]:
    """Returns a function that reads the largest value of this force, over all people, from the summary of a run."""

    def read(summary: dict) -> float | None:
        values = [person[key] for person in summary.get("people") or [] if person.get(key) is not None]
        return max(values) if values else None

    return read


def law_figures(outcomes: Sequence[Outcome]) -> dict:
    """Returns the medians over the runs, and the number of runs that passed. A median is None if no run measured the
    quantity."""
    return {
        "runs": len(outcomes),
        "passed": sum(o.passed for o in outcomes),
        "rms_position_mm": _median(outcomes, _tracking("rms_position_mm")),
        "rms_orientation_deg": _median(outcomes, _tracking("rms_orientation_deg")),
        "force_rms_N": _median(outcomes, _force("force_rms_N")),
        "force_peak_N": _median(outcomes, _force("force_peak_N")),
    }


def compare_laws(ours: Sequence[Outcome], paper: Sequence[Outcome]) -> list[dict]:
    """Returns one row per scenario that compares both laws over the same seeds."""
    rows = []
    for name in SCENARIOS:
        theirs = [o for o in paper if o.job.scenario == name]
        seeds = {o.job.seed for o in theirs}
        same = [o for o in ours if o.job.scenario == name and o.job.recording is None and o.job.seed in seeds]
        rows.append({"scenario": name, "default": law_figures(same), "paper": law_figures(theirs)})
    return rows


def laws_markdown(rows: Sequence[dict]) -> str:
    gains = dict(PAPER_GAINS)
    lines = [
        "# The default control law and the paper's",
        "",
        f"Medians over {rows[0]['paper']['runs']} seeds. The paper's law: error in the torso's frame, W = 1, "
        f"K = diag({gains['gain_w_per_s']:g} x4, {gains['gain_dual_w_per_s']:g} x4)/s, lambda = {gains['damping']:g} "
        "(docs/gains.md). Force: at the person's hand; a dash: nothing was held or measured.",
        "",
        "| scenario | law | position RMS [mm] | orientation RMS [deg] | force RMS / peak [N] | success |",
        "|---|---|---|---|---|---|",
    ]
    for row in rows:
        for law in ("default", "paper"):
            f = row[law]
            force = f"{shown(f['force_rms_N'])} / {shown(f['force_peak_N'])}"
            lines.append(
                f"| {row['scenario']} | {law} | {shown(f['rms_position_mm'])} | {shown(f['rms_orientation_deg'])} "
                f"| {force} | {f['passed']} of {f['runs']} |"
            )
    return "\n".join(lines) + "\n"
