"""Joint positions and commanded rates, with their limits."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from comanip import core
from comanip.plotting import style
from comanip.plotting.geometry import ARM
from comanip.plotting.run import JOINTS, Run

JOINT_NAMES = ("shoulder pitch", "shoulder roll", "shoulder torsion", "elbow")


def _limit(panel: Axes, value: float) -> None:
    panel.axhline(value, color=style.BLACK, linewidth=0.9, linestyle=(0, (5, 3)))


def positions_figure(run: Run) -> Figure:
    """A panel per joint; dashed: its usable range, one degree inside the stops."""
    arm = core.Arm.named(ARM)
    title = f"{run.scenario}: joint positions (dashed: usable range)"
    figure, panels = style.time_figure(run, title, [1.0] * JOINTS)
    some = style.drawn(run)
    position_deg = np.degrees(run.joints("q{}_rad"))
    for joint, panel in enumerate(panels):
        low, high = np.degrees([arm.position_min_rad[joint], arm.position_max_rad[joint]])
        panel.plot(run.t_s[some], position_deg[some, joint], color=style.FOUR[joint], linewidth=1.6)
        _limit(panel, low)
        _limit(panel, high)
        margin = 0.06 * (high - low)
        panel.set_ylim(low - margin, high + margin)
        panel.set_ylabel(f"{JOINT_NAMES[joint]}\n[deg]")
    figure.align_ylabels(panels)
    return figure


def rates_figure(run: Run) -> Figure:
    """A panel per joint; dashed: the speed limit."""
    limit = float(core.Arm.named(ARM).velocity_max_radps[0])
    title = f"{run.scenario}: commanded joint rates (dashed: limit of +-{limit:.2f} rad/s)"
    figure, panels = style.time_figure(run, title, [1.0] * JOINTS)
    some = style.drawn(run)
    rate = run.joints("dq{}_command_radps")
    for joint, panel in enumerate(panels):
        panel.plot(run.t_s[some], rate[some, joint], color=style.FOUR[joint], linewidth=0.9)
        _limit(panel, -limit)
        _limit(panel, limit)
        panel.set_ylim(-1.15 * limit, 1.15 * limit)
        panel.set_ylabel(f"{JOINT_NAMES[joint]}\n[rad/s]")
        peak = np.nanmax(np.abs(rate[:, joint])) if np.isfinite(rate[:, joint]).any() else 0.0
        panel.set_title(f"peak {peak:.2f} rad/s", fontsize=8, fontweight="normal", loc="right", pad=2)
    figure.align_ylabels(panels)
    return figure
