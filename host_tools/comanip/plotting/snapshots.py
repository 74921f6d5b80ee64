"""The scene at one instant: the arm's links, the people's hands and forearms, and what they handle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mpl_toolkits.mplot3d.axes3d import Axes3D

from comanip.plotting import style
from comanip.plotting.geometry import link_points_m, rotation_matrices
from comanip.plotting.paths import MM_PER_M, equal_limits, plain_panes
from comanip.plotting.run import Run
from comanip.plotting.shapes import Shapes

FOREARM_M = 0.12  # of a person, as far as it is drawn
GRIP_TRAIL_S = 3.0  # of the hands' paths before the instant


@dataclass(frozen=True)
class Snapshot:
    """What is drawn, in torso axes [m]; a line is (n, 3)."""

    t_s: float
    arm: np.ndarray
    people: list[tuple[np.ndarray, str]]  # hand first, with its colour
    things: list[tuple[np.ndarray, str]]
    trails: list[tuple[np.ndarray, str]]

    def points(self) -> np.ndarray:
        lines = [self.arm] + [line for line, _ in self.people + self.things + self.trails]
        return np.concatenate(lines)


def _hand(run: Run, what: str, tick: int) -> tuple[np.ndarray, np.ndarray]:
    return run.position_m(what)[tick], rotation_matrices(run.rotation(what)[tick : tick + 1])[0]


def object_lines(run: Run, shapes: Shapes, tick: int) -> list[np.ndarray]:
    """A rod lies along its z axis. A crank's pose is its hinge's, which turns; the handle is parallel to it, at +x."""
    middle, rotation = _hand(run, "object", tick)
    if shapes.rod_m is not None:
        half = 0.5 * shapes.rod_m * rotation[:, 2]
        return [np.array([middle - half, middle + half])]
    if shapes.crank_m is not None:
        radius, length = shapes.crank_m
        foot = middle + radius * rotation[:, 0]
        half = 0.5 * length * rotation[:, 2]
        return [np.array([middle, foot]), np.array([foot - half, foot + half])]
    return []


def take(run: Run, shapes: Shapes, t_s: float) -> Snapshot:
    """The snapshot at the tick nearest to t_s."""
    tick = run.index_at(t_s)
    first = run.index_at(t_s - GRIP_TRAIL_S)
    people, things, trails = [], [], []
    for what, colour in (("person", style.PERSON), ("second", style.SECOND)):
        if run.has(f"{what}_x_m"):
            position, rotation = _hand(run, what, tick)
            people.append((np.array([position, position - FOREARM_M * rotation[:, 2]]), colour))
            trails.append((run.position_m(what)[first : tick + 1 : 20], colour))
    trails.append((run.position_m("hand")[first : tick + 1 : 20], style.ROBOT))
    for cup, what, colour in ((shapes.robot_cup, "hand", style.ROBOT), (shapes.person_cup, "person", style.PERSON)):
        if cup is not None and run.has(f"{what}_x_m"):
            things += [(line, colour) for line in cup.outline_m(*_hand(run, what, tick))]
    if run.has("object_x_m"):
        things += [(line, style.OBJECT) for line in object_lines(run, shapes, tick)]
    arm = link_points_m(run.joints("q{}_rad")[tick : tick + 1])[0]
    return Snapshot(float(run.t_s[tick]), arm, people, things, trails)


def draw(panel: Axes3D, snapshot: Snapshot, around_m: np.ndarray, view: tuple[float, float]) -> None:
    """around_m: (n, 3) points that all snapshots of a figure have in view, so that they compare."""
    panel.set_proj_type("ortho")
    for line, colour in snapshot.trails:
        panel.plot(*(MM_PER_M * line).T, color=colour, linewidth=0.8, alpha=0.55)
    for line, colour in snapshot.things:
        is_rod = len(line) == 2 and colour == style.OBJECT
        panel.plot(*(MM_PER_M * line).T, color=colour, linewidth=3.2 if is_rod else 1.1, solid_capstyle="round")
    arm = MM_PER_M * snapshot.arm
    panel.plot(*arm.T, color=style.BLACK, linewidth=3.6, solid_capstyle="round", solid_joinstyle="round")
    panel.plot(*arm[:-1].T, "o", color="white", markeredgecolor=style.BLACK, markersize=4.5)
    panel.plot(*arm[-1:].T, "o", color=style.ROBOT, markersize=6.5)
    for line, colour in snapshot.people:
        panel.plot(*(MM_PER_M * line).T, color=colour, linewidth=3.0, alpha=0.75)
        panel.plot(*(MM_PER_M * line[:1]).T, "o", color=colour, markersize=6.5)
    equal_limits(panel, MM_PER_M * around_m)
    plain_panes(panel)
    panel.view_init(elev=view[0], azim=view[1])
    for axis in (panel.xaxis, panel.yaxis, panel.zaxis):
        axis.set_major_locator(style.plt.MultipleLocator(100))
        axis.set_tick_params(labelsize=6, pad=-3)
