"""Defines the common style of all figures: fonts, the palette (Okabe and Ito 2008, distinguishable by colour-blind
readers), and how events and modes are drawn."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.patches import Patch

from comanip.plotting.run_data import RunData

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
GREY, PALE = "#6E6E6E", "#D8D8D8"
ROBOT, PERSON, SECOND, OBJECT, TARGET, LIMIT = BLUE, VERMILION, PURPLE, GREEN, BLACK, GREY
JOINT_COLOURS = (BLUE, ORANGE, GREEN, PURPLE)
MODE_COLOURS = {"cooperating": "#EAF3FA", "hold": "#FDEFD3", "fault": "#F8D9CC"}

DPI = 160
MAX_DRAWN = 4000  # maximum number of points per curve, more than the figure's width in pixels
LABEL_INCH = 0.115  # height of an event label's text
CHARACTER_INCH = 0.055  # width of a character in an event label

plt.rcParams.update(
    {
        "font.family": "sans-serif",
        "font.sans-serif": ["DejaVu Sans"],
        "font.size": 9,
        "axes.titlesize": 10,
        "axes.labelsize": 9,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.linewidth": 0.7,
        "axes.grid": True,
        "axes.axisbelow": True,
        "grid.color": "#E4E4E4",
        "grid.linewidth": 0.5,
        "xtick.labelsize": 8,
        "ytick.labelsize": 8,
        "legend.fontsize": 8,
        "legend.frameon": False,
        "lines.linewidth": 1.3,
        "lines.solid_capstyle": "round",
    }
)


def thinned(run: RunData) -> slice:
    """Returns a slice that selects every k-th tick, with k such that at most MAX_DRAWN ticks are drawn."""
    return slice(None, None, max(1, -(-len(run.t_s) // MAX_DRAWN)))


def heading(run: RunData, what: str) -> str:
    recording = (run.summary.get("recording") or {}).get("file")
    motion = f"recording {Path(recording).name}" if recording else f"seed {run.summary['seed']}"
    return f"{what}: {run.scenario}, {motion}, {run.summary['result']}"


def legend_beside(axes: Axes) -> None:
    """Adds a legend to the right of the axes, where it does not cover any data."""
    if axes.get_legend_handles_labels()[1]:
        axes.legend(loc="upper left", bbox_to_anchor=(1.005, 1.03), borderaxespad=0.0, handlelength=1.6)


def spread(positions: Sequence[float], gap: float, low: float, high: float) -> np.ndarray:
    """Spreads ascending positions within low..high so that neighbours are at least `gap` apart. Positions that are too
    close are moved apart in both directions. If low..high is too short for all gaps, the positions are evenly
    spaced."""
    ideal = np.asarray(positions, float)
    if len(ideal) < 2:
        return np.clip(ideal, low, high)
    gap = min(gap, (high - low) / (len(ideal) - 1))
    steps = gap * np.arange(len(ideal))
    left = np.maximum.accumulate(ideal - steps) + steps
    right = np.minimum.accumulate((ideal - steps)[::-1])[::-1] + steps
    middle = (left + right) / 2.0
    middle = np.minimum(middle, high - gap * np.arange(len(ideal))[::-1])
    return np.maximum(middle, low + steps)


def mark_time(run: RunData, rows: Sequence[Axes], labels: bool = True) -> None:
    """Draws modes as bands and events as lines in all rows, which share a time axis. If `labels` is True, writes the
    events' names above the first row."""
    begin_s, end_s = float(run.t_s[0]), float(run.t_s[-1])
    for axes in rows:
        axes.set_xlim(begin_s, end_s)
        for from_s, until_s, mode in run.modes():
            if mode in MODE_COLOURS:
                axes.axvspan(from_s, until_s, color=MODE_COLOURS[mode], lw=0, zorder=0)
        for event in run.events:
            axes.axvline(event.t_s, color="#9A9A9A", lw=0.5, ls=(0, (1, 2)), zorder=1)
        axes.label_outer()
    rows[-1].set_xlabel("time [s]")
    _explain_modes(run, rows[-1])
    if labels:
        _label_events(run, rows[0], end_s - begin_s)


def _explain_modes(run: RunData, axes: Axes) -> None:
    """Adds a legend for the bands. The legend is placed beside the label of the time axis."""
    seen = [mode for mode in MODE_COLOURS if mode in {name for _, _, name in run.modes()}]
    handles = [Patch(facecolor=MODE_COLOURS[mode], edgecolor=PALE, label=mode) for mode in seen]
    # Added to the figure as an artist, because axes.legend() would replace the legend of the curves.
    legend = Legend(axes.figure, handles, seen, loc="lower right", bbox_to_anchor=(0.995, 0.002), ncols=len(seen) or 1)
    axes.figure.add_artist(legend)


def _label_events(run: RunData, axes: Axes, span_s: float) -> None:
    width_inch = axes.get_position().width * axes.figure.get_figwidth()
    gap_s = span_s * LABEL_INCH / width_inch
    label_times_s = spread([event.t_s for event in run.events], gap_s, run.t_s[0], run.t_s[-1])
    for event, label_s in zip(run.events, label_times_s, strict=True):
        axes.annotate(
            event.name.replace("_", " "),
            xy=(event.t_s, 1.0),
            xycoords=axes.get_xaxis_transform(),
            xytext=(label_s, 1.0 + 0.16 / (axes.get_position().height * axes.figure.get_figheight())),
            textcoords=axes.get_xaxis_transform(),
            rotation=90,
            ha="center",
            va="bottom",
            fontsize=6.5,
            color=GREY,
            arrowprops={"arrowstyle": "-", "color": "#9A9A9A", "lw": 0.5, "shrinkA": 0, "shrinkB": 0},
            annotation_clip=False,
        )


def time_figure(run: RunData, what: str, rows: int, row_inch: float = 1.5) -> tuple[Figure, list[Axes]]:
    """Creates a figure with rows that share the time axis. Leaves room for the events' names above the rows, and for
    legends to their right."""
    longest = max((len(event.name) for event in run.events), default=0)
    top_inch = 0.4 + (0.2 + CHARACTER_INCH * longest if longest else 0.0)
    height = top_inch + rows * row_inch + 0.45
    figure, axes = plt.subplots(rows, 1, sharex=True, squeeze=False, figsize=(9.5, height))
    figure.subplots_adjust(left=0.085, right=0.825, bottom=0.42 / height, top=1 - top_inch / height, hspace=0.13)
    figure.text(0.01, 1 - 0.12 / height, heading(run, what), fontsize=11, fontweight="bold", va="top")
    return figure, list(axes[:, 0])


def save(figure: Figure, path: Path) -> Path:
    figure.savefig(path, dpi=DPI, metadata={"Software": None})
    plt.close(figure)
    return path
