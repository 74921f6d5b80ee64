"""Draws the figure of an experiment: four snapshots of the scene, and the curves that show whether it succeeded."""

from __future__ import annotations

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from comanip.plotting import geometry, style, time_plots
from comanip.plotting.run_data import Cup, RunData
from comanip.plotting.scenes import SCENES, Scene

SNAPSHOTS = 4
WIDTH_INCH = 11.0
TORSO_M = np.array([[0.0, 0.0, 0.0], [-0.035, 0.0, 0.125]])  # waist and chest, from the HOAP-3 manual
FOREARM_M = 0.16  # length of the person's forearm in the drawing
SCALE_BAR_M = 0.1
CARRIER_COLOURS = {"hand": style.ROBOT, "person": style.PERSON, "second": style.SECOND}
RING = np.linspace(0.0, 2.0 * np.pi, 41)


def plain_scene(run: RunData) -> Scene:
    """Returns the layout of the figure for a user's scenario. The object in the scenario determines which curves are
    drawn."""
    curves = {"rod": "handing", "crank": "crank"}
    decisive = "water" if run.has("water_robot") else curves[run.thing.kind] if run.thing else "tracking"
    return Scene(run.scenario, (), decisive)


def instants(run: RunData, scene: Scene) -> list[tuple[float, str]]:
    """Returns (time, caption) of each snapshot. If all events of the scene occurred, the times and captions are those
    of the scene. Otherwise the times are evenly spaced over the cooperation, and the captions are empty."""
    starts = [(run.event_s(event), after_s, caption) for event, after_s, caption in scene.instants]
    if starts and all(start is not None for start, _, _ in starts):
        return [(start + after_s, caption) for start, after_s, caption in starts]
    spans = [(a, b) for a, b, mode in run.modes() if mode == "cooperating"] or [(run.t_s[0], run.t_s[-1])]
    times = np.linspace(spans[0][0], spans[-1][1], SNAPSHOTS + 1)[1:] - 1e-3
    return [(float(t), "") for t in times]


class View:
    """An orthographic projection with a given azimuth and elevation, from points in torso axes (..., 3) to points in
    the drawing plane (..., 2), in m."""

    def __init__(self, azimuth_deg: float, elevation_deg: float) -> None:
        a, e = np.radians([azimuth_deg, elevation_deg])
        right = [-np.sin(a), np.cos(a), 0.0]
        up = [-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)]
        self._axes = np.array([right, up]).T

    def __call__(self, points_m: np.ndarray) -> np.ndarray:
        return np.asarray(points_m) @ self._axes


def _line(axes: Axes, view: View, points_m: np.ndarray, **style_: object) -> None:
    axes.plot(*view(points_m).T, **style_)


def _perpendicular(axis: np.ndarray) -> np.ndarray:
    other = np.eye(3)[np.argmin(np.abs(axis))]
    across = np.cross(axis, other)
    return across / np.linalg.norm(across)


def _draw_cup(axes: Axes, view: View, run: RunData, row: int, cup: Cup, colour: str) -> None:
    turn, origin = run.rotation(cup.carrier)[row : row + 1], run.position_m(cup.carrier)[row]
    bottom = origin + geometry.rotate(turn, np.array(cup.mount_m))[0]
    axis = geometry.rotate(turn, np.array(cup.axis))[0]
    u = _perpendicular(axis)
    v = np.cross(axis, u)
    ring = cup.radius_m * (np.cos(RING)[:, None] * u + np.sin(RING)[:, None] * v)
    low, high = bottom + ring, bottom + cup.height_m * axis + ring
    _line(axes, view, low, color=colour, lw=1.0, zorder=6)
    _line(axes, view, high, color=colour, lw=1.4, zorder=6)
    # Of the straight lines along the wall, draw the two that are farthest from the projected axis: the cup's outline.
    along = view(axis)
    across = np.array([-along[1], along[0]])
    side = view(ring) @ across
    for k in (int(np.argmin(side)), int(np.argmax(side))):
        _line(axes, view, np.stack([low[k], high[k]]), color=colour, lw=1.4, zorder=6)


def _draw_person(axes: Axes, view: View, run: RunData, row: int, what: str, colour: str) -> None:
    hand = run.position_m(what)[row]
    if not np.isfinite(hand).all():
        return
    forward = geometry.rotate(run.rotation(what)[row : row + 1], np.array([0.0, 0.0, 1.0]))[0]
    _line(axes, view, np.stack([hand - FOREARM_M * forward, hand]), color=colour, lw=4.5, alpha=0.55, zorder=4)
    _line(axes, view, hand[None], color=colour, marker="o", ms=7, mec="white", mew=0.8, zorder=7)


def _draw_object(axes: Axes, view: View, run: RunData, row: int) -> None:
    middle, thing = run.position_m("object")[row], run.thing
    if thing is None or not np.isfinite(middle).all():
        return
    turn = np.repeat(run.rotation("object")[row : row + 1], 2, axis=0)
    outward, along = geometry.rotate(turn, np.eye(3)[[0, 2]])
    ends = np.array([[-0.5], [0.5]]) * along
    thick = {"color": style.OBJECT, "lw": 3.2, "zorder": 5}
    if thing.kind == "rod":
        _line(axes, view, middle + thing.length_m * ends, **thick)
    else:
        handle = middle + thing.radius_m * outward
        _line(axes, view, handle + thing.length_m * ends, **thick)
        _line(axes, view, np.stack([middle, handle]), color=style.OBJECT, lw=1.8, zorder=5)
        _line(axes, view, middle[None], color="white", marker="o", ms=5, mec=style.OBJECT, mew=1.4, zorder=8)


def _draw_trails(axes: Axes, view: View, run: RunData, row: int) -> None:
    step = max(1, row // 400)
    for what, colour in (("hand", style.ROBOT), ("person", style.PERSON), ("second", style.SECOND)):
        _line(axes, view, run.position_m(what)[: row + 1 : step], color=colour, lw=0.7, alpha=0.8, zorder=3)


def _draw_snapshot(axes: Axes, view: View, run: RunData, row: int, arm_m: np.ndarray) -> None:
    _draw_trails(axes, view, run, row)
    _line(axes, view, np.vstack([TORSO_M, arm_m[:1]]), color=style.PALE, lw=7.0, zorder=1)
    _line(axes, view, arm_m, color=style.ROBOT, lw=4.5, alpha=0.65, zorder=4)
    _line(axes, view, arm_m[:-1], color="white", marker="o", ms=3.5, ls="none", mec=style.ROBOT, zorder=7)
    _line(axes, view, arm_m[-1:], color=style.ROBOT, marker="o", ms=7, mec="white", mew=0.8, zorder=7)
    _draw_person(axes, view, run, row, "person", style.PERSON)
    _draw_person(axes, view, run, row, "second", style.SECOND)
    _draw_object(axes, view, run, row)
    for cup in run.cups:
        if np.isfinite(run.position_m(cup.carrier)[row]).all():
            _draw_cup(axes, view, run, row, cup, CARRIER_COLOURS[cup.carrier])


def _frame(panels: list[Axes]) -> float:
    """Sets the same limits and scale for all panels and draws a scale bar. Returns the ratio of height to width."""
    limits = np.array([[*p.get_xlim(), *p.get_ylim()] for p in panels])
    x0, x1 = limits[:, 0].min(), limits[:, 1].max()
    y0, y1 = limits[:, 2].min(), limits[:, 3].max()
    for panel in panels:
        panel.set(xlim=(x0, x1), ylim=(y0 - 0.03, y1), aspect="equal")
        panel.axis("off")
    first = panels[0]
    first.plot([x0, x0 + SCALE_BAR_M], [y0 - 0.02] * 2, color=style.BLACK, lw=1.5, solid_capstyle="butt")
    first.text(x0 + SCALE_BAR_M / 2, y0 - 0.026, f"{1e3 * SCALE_BAR_M:g} mm", ha="center", va="top", fontsize=7)
    return (y1 - y0 + 0.03) / (x1 - x0)


def _lay_out(figure: Figure, panels: list[Axes], rows: list[Axes], section: float) -> float:
    """Places the snapshots in a row just high enough for them, and the curves below. Returns the figure's height in
    inches."""
    gap, width = 0.1, 10.8 / SNAPSHOTS - 0.1
    panel = min(3.4, width * section)
    bottoms = (2.12, 0.48)  # lower edges of the two rows of curves
    curve = 1.5
    base = bottoms[0] + curve + 0.35
    height = base + panel + 0.72
    figure.set_size_inches(WIDTH_INCH, height)
    for k, axes in enumerate(panels):
        axes.set_position(((0.1 + k * (width + gap)) / WIDTH_INCH, base / height, width / WIDTH_INCH, panel / height))
    for axes, bottom in zip(rows, bottoms, strict=True):
        axes.set_position((0.075, bottom / height, 0.77, curve / height))
    return height


def _legend(figure: Figure, run: RunData, height: float) -> None:
    entries = [("torso", style.PALE), ("robot's arm", style.ROBOT), ("person", style.PERSON)]
    if run.has("second_x_m"):
        entries.append(("second person", style.SECOND))
    if run.has("object_x_m"):
        entries.append(("object", style.OBJECT))
    handles = [plt.Line2D([], [], color=colour, lw=3.5, label=label) for label, colour in entries]
    figure.legend(handles=handles, loc="upper right", ncols=len(handles), bbox_to_anchor=(0.995, 1 - 0.05 / height))


# ---- the curves that show whether the experiment succeeded


def _displacement_mm(run: RunData, what: str, since_s: float) -> np.ndarray:
    position = run.position_m(what)
    return 1e3 * (position - position[run.row_at(since_s)])


def _plot_water(run: RunData, rows: list[Axes]) -> None:
    time_plots.plot_water(run, rows[0])
    part = style.thinned(run)
    for cup in run.cups:
        if cup.carrier == "hand":
            tilt = geometry.tilt_deg(run.rotation("hand")[part], np.array(cup.axis))
            rows[1].plot(run.t_s[part], tilt, color=style.ROBOT, label="tilt of the glass")
    time_plots.draw_limits(rows[1], run.limits("deg"), "deg")
    rows[1].set_ylabel("tilt [deg]")


def _plot_carrying(run: RunData, rows: list[Axes]) -> None:
    part, since_s = style.thinned(run), run.event_s("operator.started") or float(run.t_s[0])
    for k, (axis, colour) in enumerate(zip("xyz", (style.BLUE, style.ORANGE, style.GREEN), strict=True)):
        for what, line, width in (("hand", "-", 1.4), ("person", ":", 1.8)):
            label = f"{'robot' if what == 'hand' else 'person'} {axis}"
            way = _displacement_mm(run, what, since_s)[part, k]
            rows[0].plot(run.t_s[part], way, color=colour, ls=line, lw=width, label=label)
    rows[0].set_ylabel("displacement [mm]")
    time_plots.plot_force(run, rows[1])


def _plot_handing(run: RunData, rows: list[Axes]) -> None:
    part = style.thinned(run)
    taker, name = ("second", "2nd person") if run.has("second_x_m") else ("person", "person")
    colour = style.SECOND if taker == "second" else style.PERSON
    for what, label, line_colour in (("hand", "robot's hand", style.ROBOT), (taker, f"{name}'s", colour)):
        distance = 1e3 * np.linalg.norm(run.position_m("object") - run.position_m(what), axis=1)
        rows[0].plot(run.t_s[part], distance[part], color=line_colour, label=f"to the {label}")
    rows[0].set_ylabel("object's distance\n[mm]")
    rows[1].plot(run.t_s[part], 1e3 * run.position_m("object")[part, 2], color=style.OBJECT, label="object's height")
    rows[1].set_ylabel("z [mm]")


def _plot_crank(run: RunData, rows: list[Axes]) -> None:
    time_plots.plot_crank(run, rows[0])
    time_plots.plot_force(run, rows[1])


def _plot_tracking(run: RunData, rows: list[Axes]) -> None:
    part, since_s = style.thinned(run), float(run.t_s[0])
    for k, (axis, colour) in enumerate(zip("xyz", (style.BLUE, style.ORANGE, style.GREEN), strict=True)):
        way = _displacement_mm(run, "hand", since_s)[part, k]
        rows[0].plot(run.t_s[part], way, color=colour, label=f"robot {axis}")
    rows[0].set_ylabel("displacement [mm]")
    error = 1e3 * np.linalg.norm(run.position_m("hand") - run.position_m("target"), axis=1)
    rows[1].plot(run.t_s[part], error[part], color=style.VERMILION, label="distance from target")
    rows[1].set_ylabel("error [mm]")


DECISIVE = {
    "water": _plot_water,
    "carrying": _plot_carrying,
    "handing": _plot_handing,
    "crank": _plot_crank,
    "tracking": _plot_tracking,
}


def experiment(run: RunData) -> Figure:
    scene = SCENES.get(run.scenario) or plain_scene(run)
    moments = instants(run, scene)
    figure = plt.figure()
    panels = [figure.add_subplot(3, SNAPSHOTS, k + 1) for k in range(SNAPSHOTS)]
    upper = figure.add_subplot(3, 1, 2)
    rows = [upper, figure.add_subplot(3, 1, 3, sharex=upper)]

    view = View(*scene.view_deg)
    at = [run.row_at(t_s) for t_s, _ in moments]
    arms = geometry.arm_points_m(run.joints_rad()[at])
    for k, (panel, row, (t_s, caption)) in enumerate(zip(panels, at, moments, strict=True)):
        _draw_snapshot(panel, view, run, row, arms[k])
        panel.set_title(f"({'abcd'[k]}) {t_s:.1f} s{': ' if caption else ''}{caption}", fontsize=9)
    height = _lay_out(figure, panels, rows, _frame(panels))

    DECISIVE[scene.decisive](run, rows)
    for row in rows:
        style.legend_beside(row)
    style.mark_time(run, rows, labels=False)
    for k, (t_s, _) in enumerate(moments):
        upper.annotate(
            "abcd"[k],
            xy=(t_s, 1.0),
            xycoords=upper.get_xaxis_transform(),
            xytext=(0, 4),
            textcoords="offset points",
            ha="center",
            fontweight="bold",
            annotation_clip=False,
        )
        for row in rows:
            row.axvline(t_s, color=style.BLACK, lw=0.8, zorder=2)
    figure.align_ylabels(rows)
    figure.text(0.012, 1 - 0.1 / height, style.heading(run, scene.title), fontsize=12, fontweight="bold", va="top")
    _legend(figure, run, height)
    return figure
