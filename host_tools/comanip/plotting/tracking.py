"""Target against measured: position by axis, and orientation."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from comanip.plotting import style
from comanip.plotting.geometry import angle_between_deg
from comanip.plotting.run import Run

MM_PER_M = 1e3


def position_error_mm(run: Run) -> np.ndarray:
    """(ticks, 3): the hand less the target; NaN without one."""
    return MM_PER_M * (run.position_m("hand") - run.position_m("target"))


def _rms(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else float("nan")


def position_figure(run: Run) -> Figure:
    """Six panels: for each axis target and hand, and the error below."""
    figure, panels = style.time_figure(run, f"{run.scenario}: position of the robot's hand", [1.0, 0.6] * 3)
    some = style.drawn(run)
    t_s, error_mm = run.t_s[some], position_error_mm(run)
    target_mm, hand_mm = MM_PER_M * run.position_m("target"), MM_PER_M * run.position_m("hand")
    for axis, name in enumerate("xyz"):
        over, under = panels[2 * axis : 2 * axis + 2]
        over.plot(t_s, hand_mm[some, axis], color=style.ROBOT, linewidth=1.8, label="measured (ODE)")
        over.plot(t_s, target_mm[some, axis], color=style.TARGET, linewidth=1.0, linestyle=(0, (4, 2)), label="target")
        over.set_ylabel(f"${name}$ [mm]")
        under.axhline(0, color=style.GREY, linewidth=0.8)
        under.plot(t_s, error_mm[some, axis], color=style.VERMILION, linewidth=1.0)
        under.set_ylabel(f"error ${name}$\n[mm]")
        under.set_title(f"RMS {_rms(error_mm[:, axis]):.2f} mm", fontsize=8, fontweight="normal", loc="right", pad=2)
    style.legend_above(panels[0])
    figure.align_ylabels(panels)
    return figure


def orientation_figure(run: Run) -> Figure:
    """The angle between the hand and its target: four joints cannot meet all of them."""
    figure, (panel,) = style.time_figure(run, f"{run.scenario}: orientation error of the robot's hand", [1.8])
    error_deg = angle_between_deg(run.rotation("target"), run.rotation("hand"))
    some = style.drawn(run)
    panel.plot(run.t_s[some], error_deg[some], color=style.VERMILION)
    panel.set_ylim(bottom=0)
    style.room_above(panel)
    panel.set_ylabel("angle to the target [deg]")
    panel.set_title(f"RMS {_rms(error_deg):.2f} deg", fontsize=8, fontweight="normal", loc="right", pad=2)
    return figure
