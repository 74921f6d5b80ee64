"""Plots quantities of a run over time, with one function per figure. Each returns the figure, or None if the run lacks
the data."""

from __future__ import annotations

import itertools

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter

from comanip.core.arm import Arm
from comanip.plotting import geometry, style
from comanip.plotting.run_data import JOINTS, RunData

LOG_RATIO = 30.0  # the axis is logarithmic if the ratio of largest to smallest clearance is above this


def tracking(run: RunData) -> Figure | None:
    """Plots the positions of target and simulated end effector for each axis, with the error below."""
    if not run.has("target_x_m"):
        return None
    figure, rows = style.time_figure(run, "Target and robot's hand", 6, 1.05)
    part, t = style.thinned(run), run.t_s
    target, hand = run.position_m("target"), run.position_m("hand")
    error_mm = 1e3 * (hand - target)
    for k, axis in enumerate("xyz"):
        position, error = rows[2 * k], rows[2 * k + 1]
        position.plot(t[part], 1e3 * target[part, k], color=style.TARGET, lw=2.2, alpha=0.35, label="target")
        position.plot(t[part], 1e3 * hand[part, k], color=style.ROBOT, label="robot's hand")
        position.set_ylabel(f"{axis} [mm]")
        error.plot(t[part], error_mm[part, k], color=style.VERMILION, lw=0.9, label="hand - target")
        error.axhline(0.0, color=style.GREY, lw=0.5)
        error.set_ylabel("error [mm]")
        if k == 0:
            style.legend_beside(position)
            style.legend_beside(error)
    figure.align_ylabels(rows)
    style.mark_time(run, rows)
    return figure


def orientation(run: RunData) -> Figure | None:
    if not run.has("target_qw"):
        return None
    figure, (axes,) = style.time_figure(run, "Orientation error", 1, 2.6)
    part = style.thinned(run)
    error = geometry.angle_between_deg(run.rotation("target")[part], run.rotation("hand")[part])
    axes.plot(run.t_s[part], error, color=style.ROBOT, label="hand to target")
    axes.set_ylabel("angle [deg]")
    axes.set_ylim(bottom=0.0)
    style.legend_beside(axes)
    style.mark_time(run, [axes])
    return figure


def joints(run: RunData) -> Figure:
    """Plots the joint positions within their usable ranges, and the commanded velocities with their limits."""
    figure, rows = style.time_figure(run, "Joints", 2 * JOINTS, 0.95)
    arm, part = Arm.named(geometry.ARM), style.thinned(run)
    position_deg, rates = np.degrees(run.joints_rad())[part], run.rates_radps()[part]
    for i in range(JOINTS):
        low = np.degrees(arm.position_min_rad[i])
        high = np.degrees(arm.position_max_rad[i])
        _limited(rows[i], run.t_s[part], position_deg[:, i], (low, high), style.JOINT_COLOURS[i], f"q{i}")
        rows[i].set_ylabel("[deg]")
        most = float(arm.velocity_max_radps[i])
        row = rows[JOINTS + i]
        _limited(row, run.t_s[part], rates[:, i], (-most, most), style.JOINT_COLOURS[i], f"rate {i}")
        row.set_ylabel("[rad/s]")
    for row in rows:
        style.legend_beside(row)
    figure.align_ylabels(rows)
    style.mark_time(run, rows)
    return figure


def _limited(axes: Axes, t: np.ndarray, values: np.ndarray, limits: tuple, colour: str, name: str) -> None:
    axes.plot(t, values, color=colour, label=name)
    for k, limit in enumerate(limits):
        axes.axhline(limit, color=style.LIMIT, ls="--", lw=0.9, label="limit" if k == 0 else None)


def clearance(run: RunData) -> Figure | None:
    curves = [
        ("clearance_person_mm", "person to robot", style.PERSON),
        ("clearance_self_mm", "arm to robot", style.ROBOT),
    ]
    shown = [curve for curve in curves if run.has(curve[0])]
    if not shown:
        return None
    figure, (axes,) = style.time_figure(run, "Clearance outside intended contact", 1, 2.6)
    part = style.thinned(run)
    for name, label, colour in shown:
        axes.plot(run.t_s[part], run.column(name)[part], color=colour, label=label)
    values = np.concatenate([run.column(name) for name, _, _ in shown])
    low, high = np.nanmin(values), np.nanmax(values)
    if low > 0.0 and high > LOG_RATIO * low:
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter(ScalarFormatter())
    else:
        axes.set_ylim(bottom=min(0.0, low))
    axes.set_ylabel("smallest distance [mm]")
    style.legend_beside(axes)
    style.mark_time(run, [axes])
    return figure


def draw_limits(axes: Axes, limits: list[tuple[str, float]], unit: str) -> None:
    """Draws a line for each limit of the scenario's checks."""
    for (name, limit), line in zip(limits, itertools.cycle(("--", ":", "-.")), strict=False):
        axes.axhline(limit, color=style.LIMIT, ls=line, lw=1.0, label=f"{name}: {limit:g} {unit}")


def plot_force(run: RunData, axes: Axes) -> None:
    """Plots the magnitude of the force at each person's hand while the hand holds something, with the scenario's
    limits."""
    part = style.thinned(run)
    force = np.sqrt(sum(run.column(f"force_{axis}_N") ** 2 for axis in "xyz"))
    if run.has("force_x_N"):
        axes.plot(run.t_s[part], force[part], color=style.PERSON, label="at the person's hand")
    if run.has("second_force_N"):
        axes.plot(run.t_s[part], run.column("second_force_N")[part], color=style.SECOND, label="second person's")
    draw_limits(axes, run.limits("N"), "N")
    axes.set_ylabel("force [N]")
    axes.set_ylim(bottom=0.0)


def force(run: RunData) -> Figure | None:
    if not (run.has("force_x_N") or run.has("second_force_N")):
        return None
    figure, (axes,) = style.time_figure(run, "Force at the hands", 1, 2.6)
    plot_force(run, axes)
    style.legend_beside(axes)
    style.mark_time(run, [axes])
    return figure


def plot_water(run: RunData, axes: Axes) -> None:
    part = style.thinned(run)
    for name, label, colour in (
        ("water_robot", "in the robot's glass", style.ROBOT),
        ("water_person", "in the person's glass", style.PERSON),
        ("water_spilt", "falling or spilt", style.BLACK),
    ):
        axes.plot(run.t_s[part], run.column(name)[part], color=colour, label=label)
    axes.set_ylabel("particles")
    axes.set_ylim(bottom=0.0)


def water(run: RunData) -> Figure | None:
    if not run.has("water_robot"):
        return None
    figure, (axes,) = style.time_figure(run, "Water", 1, 2.6)
    plot_water(run, axes)
    style.legend_beside(axes)
    style.mark_time(run, [axes])
    return figure


def plot_crank(run: RunData, axes: Axes) -> None:
    part = style.thinned(run)
    axes.plot(run.t_s[part], run.column("crank_turns")[part], color=style.OBJECT, label="crank")
    draw_limits(axes, run.limits("turn"), "turns")
    axes.set_ylabel("turns")


def crank(run: RunData) -> Figure | None:
    if not run.has("crank_turns"):
        return None
    figure, (axes,) = style.time_figure(run, "Crank", 1, 2.6)
    plot_crank(run, axes)
    style.legend_beside(axes)
    style.mark_time(run, [axes])
    return figure
