"""Computes distances and overlaps of many convex shapes at once in numpy, independently of the C sources.
Distances of boxes, capsules and cylinders are computed by projection, with a lower and an upper bound; distances of
point sets are computed by least squares, and overlaps from the facets of a hull."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation


@dataclass
class Shapes:
    """A set of n shapes of one kind. Lengths are in m; rotation maps the shape's axes to the world's; position_m has
    the shape (n, 3)."""

    kind: str  # box, capsule, cylinder
    size_m: np.ndarray  # (n, 3), for boxes
    length_m: np.ndarray  # (n,), along z: length of cylinders, distance between the cap centres of capsules
    radius_m: np.ndarray  # (n,)
    rotation: Rotation
    position_m: np.ndarray

    def project(self, point: np.ndarray) -> np.ndarray:
        """Returns the points of the shapes that are nearest to the given points (n, 3)."""
        local = self.rotation.inv().apply(point - self.position_m)
        z = np.clip(local[:, 2], -self.length_m / 2, self.length_m / 2)
        if self.kind == "box":
            nearest = np.clip(local, -self.size_m / 2, self.size_m / 2)
        elif self.kind == "cylinder":
            across = np.hypot(local[:, 0], local[:, 1])
            share = np.minimum(1, self.radius_m / np.maximum(across, 1e-300))
            nearest = np.column_stack([local[:, 0] * share, local[:, 1] * share, z])
        else:
            axis = np.column_stack([np.zeros_like(z), np.zeros_like(z), z])
            away = np.linalg.norm(local - axis, axis=1)
            nearest = axis + (local - axis) * np.minimum(1, self.radius_m / np.maximum(away, 1e-300))[:, None]
        return self.rotation.apply(nearest) + self.position_m

    def reach(self, direction: np.ndarray) -> np.ndarray:
        """Returns the support function (n,): the largest coordinate of each shape along its unit direction (n, 3),
        measured from the world's origin."""
        local = self.rotation.inv().apply(direction)
        along = np.abs(local[:, 2]) * self.length_m / 2
        if self.kind == "box":
            own = (np.abs(local) * self.size_m / 2).sum(1)
        elif self.kind == "cylinder":
            own = np.hypot(local[:, 0], local[:, 1]) * self.radius_m + along
        else:
            own = along + self.radius_m
        return own + np.einsum("ni,ni->n", self.position_m, direction)


def distance_bracket(a: Shapes, b: Shapes, steps: int = 600) -> tuple[np.ndarray, np.ndarray]:
    """Returns lower and upper bounds (n,), in m, of the distances. The upper bound is the distance between two points,
    one in each shape; the lower bound comes from a plane between the shapes.

    The two points are moved towards each other by projected gradient steps with Nesterov momentum, restarted every 100
    steps.
    """
    x, y = a.position_m, b.position_m
    x_before, y_before, t = x, y, 1.0
    lower, upper = np.zeros(len(x)), np.full(len(x), np.inf)
    for step in range(1, steps + 1):
        t_next = (1 + np.sqrt(1 + 4 * t * t)) / 2
        momentum, t = (t - 1) / t_next, t_next
        u, v = x + momentum * (x - x_before), y + momentum * (y - y_before)
        x_before, y_before = x, y
        x, y = a.project(u - 0.5 * (u - v)), b.project(v + 0.5 * (u - v))
        if step % 100 == 0:
            t = 1.0
        if step % 20 == 0:
            between = y - x
            apart = np.linalg.norm(between, axis=1)
            upper = np.minimum(upper, apart)
            direction = between / np.maximum(apart, 1e-300)[:, None]
            lower = np.maximum(lower, -a.reach(direction) - b.reach(-direction))
    return lower, upper


def hull_distance_m(a: np.ndarray, b: np.ndarray) -> float:
    """Returns the distance between the convex hulls of points (n, 3) and (m, 3).

    Uses least distance programming (Lawson and Hanson, Solving Least Squares Problems, 1974, chapter 23). Let w be the
    differences between points of the two sets. The shortest n with n . w >= 1 for all w is the normal of the widest
    slab between the hulls, and 1 / |n| is the slab's width.
    """
    differences = (a[:, None] - b[None]).reshape(-1, 3)
    rows = np.vstack([differences.T, np.ones(len(differences))])
    weights, _ = nnls(rows, np.array([0.0, 0.0, 0.0, 1.0]))
    rest = rows @ weights - [0, 0, 0, 1]
    if -rest[3] < 1e-12:
        return 0.0
    return 1.0 / np.linalg.norm(rest[:3] / rest[3])


def hull_overlap_m(a: np.ndarray, b: np.ndarray) -> float:
    """Returns the penetration depth of the convex hulls of points (n, 3) and (m, 3). This is the depth of the origin in
    the convex hull of all differences between points of the two sets, or 0 if the origin lies outside."""
    differences = (a[:, None] - b[None]).reshape(-1, 3)
    return max(0.0, -ConvexHull(differences).equations[:, 3].max())
