"""Clearance, force, water and crank over time. A panel function draws into axes it is given, for experiment.py too."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from comanip.plotting import style
from comanip.plotting.run import Run

FORCE_RMS_LIMIT_N, FORCE_PEAK_LIMIT_N = 5.0, 15.0  # of the experiments in which both carry


def force_N(run: Run) -> np.ndarray:
    """(ticks,): magnitude at the tracked person's hand."""
    return np.linalg.norm(np.stack([run.columns[f"force_{axis}_N"] for axis in "xyz"], axis=1), axis=1)


def draw_clearance(panel: Axes, run: Run) -> None:
    some = style.drawn(run)
    for key, colour, label in (
        ("person", style.PERSON, "person to robot, but for intended contact"),
        ("self", style.ROBOT, "arm to torso"),
    ):
        name = f"clearance_{key}_mm"
        if run.has(name):
            panel.plot(run.t_s[some], run.columns[name][some], color=colour, label=label)
    panel.axhline(0, color=style.BLACK, linewidth=0.9, linestyle=(0, (5, 3)))
    panel.set_ylim(bottom=min(0.0, panel.get_ylim()[0]))
    panel.set_ylabel("clearance [mm]")


def clearance_figure(run: Run) -> Figure:
    figure, (panel,) = style.time_figure(run, f"{run.scenario}: least clearance (libccd)", [2.0])
    draw_clearance(panel, run)
    for key, colour in (("person", style.PERSON), ("self", style.ROBOT)):
        least = run.summary.get("clearance") or {}
        if run.has(f"clearance_{key}_mm") and least.get(f"{key}_t_s") is not None:
            panel.plot(least[f"{key}_t_s"], least[f"{key}_mm"], "o", color=colour, markersize=5, clip_on=False)
    style.legend_above(panel)
    return figure


def draw_force(panel: Axes, run: Run) -> None:
    """Both limits are drawn even if the force stays far below: they are what it is judged by."""
    who, some = style.names(run), style.drawn(run)
    force = force_N(run)
    panel.plot(run.t_s[some], force[some], color=style.PERSON, linewidth=1.0, label=f"at the {who['person']}'s hand")
    if run.has("second_force_N"):
        second = run.columns["second_force_N"]
        panel.plot(run.t_s[some], second[some], color=style.SECOND, linewidth=1.0, label=f"at the {who['second']}'s hand")
    for limit, dashes, label in (
        (FORCE_RMS_LIMIT_N, (0, (5, 3)), "5 N (RMS limit)"),
        (FORCE_PEAK_LIMIT_N, (0, (1, 1.5)), "15 N (peak limit)"),
    ):
        panel.axhline(limit, color=style.BLACK, linewidth=0.9, linestyle=dashes, label=label)
    panel.set_ylim(0, 1.08 * max(FORCE_PEAK_LIMIT_N, float(np.nanmax(panel.dataLim.y1))))
    panel.set_ylabel("force [N]")


def force_figure(run: Run) -> Figure:
    figure, (panel,) = style.time_figure(run, f"{run.scenario}: force at the hands (ODE)", [2.0])
    draw_force(panel, run)
    style.legend_above(panel)
    return figure


def draw_water(panel: Axes, run: Run) -> None:
    some = style.drawn(run)
    for key, colour, label in (
        ("robot", style.ROBOT, "in the robot's glass"),
        ("person", style.PERSON, "in the person's glass"),
        ("spilt", style.BLACK, "spilt or falling"),
    ):
        panel.step(run.t_s[some], run.columns[f"water_{key}"][some], where="post", color=colour, label=label)
    panel.set_ylim(bottom=0)
    style.room_above(panel)
    panel.set_ylabel("water [particles]")


def water_figure(run: Run) -> Figure:
    figure, (panel,) = style.time_figure(run, f"{run.scenario}: where the water is", [2.0])
    draw_water(panel, run)
    style.legend_above(panel)
    return figure


def draw_crank(panel: Axes, run: Run) -> None:
    some = style.drawn(run)
    panel.plot(run.t_s[some], run.columns["crank_turns"][some], color=style.OBJECT, linewidth=1.8, label="crank")
    panel.axhline(3.0, color=style.BLACK, linewidth=0.9, linestyle=(0, (5, 3)), label="three turns")
    style.room_above(panel)
    panel.set_ylabel("crank [turns]")


def crank_figure(run: Run) -> Figure:
    figure, (panel,) = style.time_figure(run, f"{run.scenario}: the crank", [2.0])
    draw_crank(panel, run)
    style.legend_above(panel)
    return figure
