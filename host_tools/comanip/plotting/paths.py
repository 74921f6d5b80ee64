"""Plots the paths of the hands and of the object in 3D."""

from __future__ import annotations

import itertools

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator
from matplotlib.transforms import Bbox
from mpl_toolkits.mplot3d import Axes3D, proj3d

from comanip.plotting import style
from comanip.plotting.run_data import RunData

LEAST_HALF_MM = 60.0  # minimum half range of an axis
TICK_MM = 50.0
FRAME = (0.02, 0.02, 0.96, 0.84)  # left, bottom, width and height of the part of the figure below heading and legend
FITTINGS = 3  # iterations of the fit; one is not enough, because the labels do not scale with the box
WAYS = (
    ("target", "target", style.TARGET, 0.8),
    ("hand", "robot's hand", style.ROBOT, 1.6),
    ("person", "person's hand", style.PERSON, 1.6),
    ("second", "second person's hand", style.SECOND, 1.6),
    ("object", "object", style.OBJECT, 1.6),
)


def _corners(axes: Axes3D) -> np.ndarray:
    """Returns the corners of the box in pixels: (8, 2)."""
    corners = np.array(list(itertools.product(axes.get_xlim(), axes.get_ylim(), axes.get_zlim())))
    x, y, _ = proj3d.proj_transform(*corners.T, axes.get_proj())
    return axes.transData.transform(np.column_stack([x, y]))


def _fit(figure: Figure, axes: Axes3D, sides: np.ndarray) -> None:
    """Scales the box so that the box, its labels and its ticks together fill FRAME. sides: proportions of the box."""
    left, bottom, width, height = FRAME
    zoom = 1.0
    for line in axes.lines:
        line.set_clip_on(False)  # the box extends beyond the rectangle of its axes
    for _ in range(FITTINGS):
        axes.set_box_aspect(tuple(sides), zoom=zoom)  # one scale for all axes
        figure.canvas.draw()
        drawn = [axis.get_tightbbox(figure.canvas.get_renderer()) for axis in (axes.xaxis, axes.yaxis, axes.zaxis)]
        low, high = _corners(axes).min(axis=0), _corners(axes).max(axis=0)
        box = Bbox.union([*drawn, Bbox([low, high])]).transformed(figure.transFigure.inverted())
        zoom *= min(width / box.width, height / box.height)
        position = axes.get_position()
        x_shift = left + width / 2 - (box.x0 + box.x1) / 2
        y_shift = bottom + height / 2 - (box.y0 + box.y1) / 2
        axes.set_position((position.x0 + x_shift, position.y0 + y_shift, position.width, position.height))


def paths(run: RunData) -> Figure:
    """Draws the figure, with the same scale on all axes. Rings mark the starts of the paths, squares the ends."""
    figure = plt.figure(figsize=(8.6, 5.8))
    axes = figure.add_axes(FRAME, projection="3d")
    part = style.thinned(run)
    seen = []
    for what, label, colour, width in WAYS:
        way = 1e3 * run.position_m(what)[part]
        way = way[np.isfinite(way).all(axis=1)]
        if not len(way):
            continue
        seen.append(way)
        axes.plot(*way.T, color=colour, lw=width, label=label, ls="--" if what == "target" else "-")
        axes.plot(*way[:1].T, marker="o", mfc="white", mec=colour, ms=6, ls="none")
        axes.plot(*way[-1:].T, marker="s", color=colour, ms=5, ls="none")
    for marker, fill, label in (("o", "white", "start"), ("s", style.GREY, "end")):
        axes.plot([], [], [], marker=marker, mfc=fill, mec=style.GREY, ls="none", label=label)
    everything = np.vstack(seen)
    middle = (everything.max(axis=0) + everything.min(axis=0)) / 2
    half = np.maximum(LEAST_HALF_MM, 0.55 * np.ptp(everything, axis=0))
    low, high = middle - half, middle + half
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set_zlim(low[2], high[2])
    tick = TICK_MM * (2.0 if half.max() > 200.0 else 1.0)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_major_locator(MultipleLocator(tick))
        axis.labelpad = 10
    axes.view_init(elev=22, azim=-58)
    axes.set(xlabel="x, forward [mm]", ylabel="y, left [mm]")
    axes.set_zlabel("z, up [mm]")
    _fit(figure, axes, half)
    figure.legend(loc="upper left", bbox_to_anchor=(0.012, 0.94), ncols=4)
    figure.text(0.02, 0.97, style.heading(run, "Paths"), fontsize=11, fontweight="bold", va="top")
    return figure
