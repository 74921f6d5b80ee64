"""Checks distance and overlap of convex shapes (libccd) against closed forms, certified bounds, least squares and
the facets of hulls."""

from __future__ import annotations

import itertools

import numpy as np
import proximity_binding
import pytest
from convex_oracle import Shapes, distance_bracket, hull_distance_m, hull_overlap_m
from scipy.spatial.transform import Rotation

ffi, lib = proximity_binding.load()

ERROR_M = 0.00005  # equal to CONVEX_DISTANCE_ERROR_M
OVERLAP_ERROR_M = 0.0003  # equal to CONVEX_OVERLAP_ERROR_M
KINDS = {"box": lib.SHAPE_BOX, "capsule": lib.SHAPE_CAPSULE, "cylinder": lib.SHAPE_CYLINDER, "hull": lib.SHAPE_HULL}
CUBE = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))


def shape(kind, position_m=(0, 0, 0), rotation=None, size_m=(0, 0, 0), length_m=0.0, radius_m=0.0, points=None):
    """Returns a convex_shape_t and keeps the data it refers to alive."""
    made = ffi.new("convex_shape_t *", {"kind": KINDS[kind], "length_m": length_m, "radius_m": radius_m})
    made.size_m = list(map(float, size_m))
    made.pose.position_m = list(map(float, position_m))
    x, y, z, w = (rotation or Rotation.identity()).as_quat()
    made.pose.rotation = [w, x, y, z]
    if points is not None:
        storage = ffi.from_buffer("double[][3]", np.ascontiguousarray(points, float))
        made.points, made.point_count = storage, len(points)
        KEPT[made] = storage
    lib.convex_shape_finish(made)
    return made


KEPT: dict = {}


def random_shapes(rng, kind: str, n: int, spread_m: float = 0.25) -> Shapes:
    return Shapes(
        kind,
        rng.uniform(0.01, 0.3, (n, 3)),
        rng.uniform(0, 0.4, n),
        rng.uniform(0.005, 0.08, n),
        Rotation.random(n, rng),
        rng.uniform(-spread_m, spread_m, (n, 3)),
    )


def c_shapes(shapes: Shapes) -> list:
    rows = zip(shapes.position_m, shapes.rotation, shapes.size_m, shapes.length_m, shapes.radius_m, strict=True)
    return [shape(shapes.kind, *row) for row in rows]


def distances(a, b, ceiling_m=2.0, guess_m=None) -> np.ndarray:
    guess_m = np.full(len(a), -1.0) if guess_m is None else guess_m
    return np.array([lib.convex_distance_m(p, q, ceiling_m, g) for p, q, g in zip(a, b, guess_m, strict=True)])


# ---- distance


def test_spheres(rng):
    """Spheres are capsules of zero length."""
    a, b = random_shapes(rng, "capsule", 2500), random_shapes(rng, "capsule", 2500)
    a.length_m[:] = b.length_m[:] = 0
    apart = np.linalg.norm(a.position_m - b.position_m, axis=1) - a.radius_m - b.radius_m
    assert (apart < 0).sum() > 20
    found = distances(c_shapes(a), c_shapes(b))
    assert np.abs(found - np.maximum(apart, 0)).max() < ERROR_M
    assert (found[apart < 0] == 0).all()


def segment_distance(p0, p1, q0, q1) -> float:
    """Returns the distance between two segments: the least of the distances from the four end points and, if the common
    normal meets both segments, the length of that normal."""

    def to_segment(point, s0, s1):
        t = np.clip((point - s0) @ (s1 - s0) / ((s1 - s0) @ (s1 - s0)), 0, 1)
        return np.linalg.norm(point - s0 - t * (s1 - s0))

    best = min(to_segment(p0, q0, q1), to_segment(p1, q0, q1), to_segment(q0, p0, p1), to_segment(q1, p0, p1))
    d, e = p1 - p0, q1 - q0
    s, t = np.linalg.lstsq(np.column_stack([d, -e]), q0 - p0, rcond=None)[0]
    if 0 <= s <= 1 and 0 <= t <= 1:
        best = min(best, np.linalg.norm(p0 + s * d - q0 - t * e))
    return best


def test_capsules(rng):
    a, b = random_shapes(rng, "capsule", 2000), random_shapes(rng, "capsule", 2000)
    ends = [
        (s.position_m - s.rotation.apply([0, 0, 1]) * s.length_m[:, None] / 2,
         s.position_m + s.rotation.apply([0, 0, 1]) * s.length_m[:, None] / 2)
        for s in (a, b)
    ]  # fmt: skip
    lines = np.array([segment_distance(*four) for four in zip(*ends[0], *ends[1], strict=True)])
    expected = np.maximum(lines - a.radius_m - b.radius_m, 0)
    assert np.abs(distances(c_shapes(a), c_shapes(b)) - expected).max() < ERROR_M


@pytest.mark.parametrize("first", ["box", "capsule", "cylinder"])
@pytest.mark.parametrize("second", ["box", "capsule", "cylinder"])
def test_between_certified_bounds(rng, first, second):
    a, b = random_shapes(rng, first, 2000), random_shapes(rng, second, 2000)
    lower, upper = distance_bracket(a, b)
    assert np.quantile(upper - lower, 0.97) < 1e-6  # the oracle's own error is small
    p, q = c_shapes(a), c_shapes(b)
    found = distances(p, q)
    assert (found > lower - ERROR_M).all() and (found < upper + ERROR_M).all()
    assert (found[upper < 1e-9] == 0).all() and (found[lower > 2 * ERROR_M] > 0).all()
    guess = np.abs(found + rng.normal(size=len(found)) * 10.0 ** rng.uniform(-6, 0, len(found)))
    guessed = distances(p, q, guess_m=guess)
    assert (guessed > lower - ERROR_M).all() and (guessed < upper + ERROR_M).all()
    assert np.abs(distances(q, p) - found).max() < 2 * ERROR_M
    assert (distances(p, q, ceiling_m=0.1) <= 0.1).all()
    assert np.abs(distances(p, q, ceiling_m=0.1) - np.clip(found, 0, 0.1)).max() < 2 * ERROR_M


def random_hull(rng) -> np.ndarray:
    return rng.normal(size=(12, 3)) * rng.uniform(0.01, 0.1, 3)


def test_hulls_and_boxes(rng):
    """The distances agree with a least-squares solution over the corners, which is independent of the search by
    directions in libccd."""
    overlapping = 0
    for i in range(2000):
        points = random_hull(rng), (random_hull(rng) if i % 2 else CUBE * rng.uniform(0.01, 0.3, 3))
        turn = Rotation.random(2, rng)
        at = rng.uniform(-0.25, 0.25, (2, 3))
        world = [turn[k].apply(points[k]) + at[k] for k in range(2)]
        a = shape("hull", at[0], turn[0], points=points[0])
        if i % 2:
            b = shape("hull", at[1], turn[1], points=points[1])
        else:
            b = shape("box", at[1], turn[1], size_m=np.ptp(points[1], axis=0))
        expected = hull_distance_m(*world)
        overlapping += expected == 0
        assert abs(lib.convex_distance_m(a, b, 2.0, -1.0) - expected) < ERROR_M
    assert 100 < overlapping < 1000


@pytest.mark.parametrize("gap_m", [0.0, 1e-6, 1e-4, 0.003, 0.2, 0.9])
def test_faces_edges_and_corners(gap_m):
    cube = {"size_m": (0.1, 0.1, 0.1)}
    edge, corner = 0.1 * np.sqrt(0.5), 0.1 * np.sqrt(0.75)
    on_edge = Rotation.from_euler("x", 45, degrees=True)  # an edge on top, along x
    crossed = Rotation.from_euler("y", 45, degrees=True)  # an edge on top, along y
    on_corner = Rotation.align_vectors([[0, 0, 1]], [[1, 1, 1]])[0]
    for turn, other, height_m in [
        (None, None, 0.1),
        (on_edge, None, 0.05 + edge),
        (on_edge, crossed, 2 * edge),
        (on_corner, None, 0.05 + corner),
        (on_corner, Rotation.from_euler("x", 180, degrees=True) * on_corner, 2 * corner),
    ]:
        below = shape("box", rotation=turn, **cube)
        above = shape("box", (0.0, 0.0, height_m + gap_m), other, **cube)
        for guess_m in (-1.0, 0.0, gap_m, 0.5):
            assert abs(lib.convex_distance_m(below, above, 1.0, guess_m) - gap_m) < ERROR_M
            assert abs(lib.convex_distance_m(above, below, 1.0, guess_m) - gap_m) < ERROR_M


@pytest.mark.parametrize("kind", ["capsule", "cylinder"])
@pytest.mark.parametrize("gap_m", [0.0, 1e-5, 0.004, 0.3])
def test_parallel_and_in_line(rng, kind, gap_m):
    """The distance is correct for parallel shapes, of which many pairs of points are equally near, and for shapes in
    line, which only their end faces separate."""
    for turn in Rotation.random(100, rng):
        radius, length = rng.uniform(0.005, 0.08, 2), rng.uniform(0.05, 0.4, 2)
        end = length / 2 + (radius if kind == "capsule" else 0)
        for at in ([radius.sum() + gap_m, 0, 0], [0, -radius.sum() - gap_m, 0.02], [0, 0, end.sum() + gap_m]):
            a = shape(kind, rotation=turn, length_m=length[0], radius_m=radius[0])
            b = shape(kind, turn.apply(at), turn, length_m=length[1], radius_m=radius[1])
            for guess_m in (-1.0, gap_m):
                assert abs(lib.convex_distance_m(a, b, 1.0, guess_m) - gap_m) < ERROR_M


def test_distances_above_the_ceiling_are_the_ceiling():
    ball = {"radius_m": 0.1}
    for x_m in (0.71, 0.8, 5.0):
        a, b = shape("capsule", (1, 2, 3), **ball), shape("capsule", (1 + x_m, 2, 3), **ball)
        assert lib.convex_distance_m(a, b, 0.5, -1.0) == 0.5
        assert lib.convex_distance_m(a, b, 0.5, 0.2) == 0.5


def test_bounding_radius_reaches_the_furthest_point(rng):
    assert shape("box", size_m=(0.3, 0.4, 1.2)).bounding_radius_m == pytest.approx(0.65)
    assert shape("capsule", length_m=0.2, radius_m=0.05).bounding_radius_m == pytest.approx(0.15)
    assert shape("cylinder", length_m=0.6, radius_m=0.4).bounding_radius_m == pytest.approx(0.5)
    points = random_hull(rng)
    assert shape("hull", points=points).bounding_radius_m == pytest.approx(np.linalg.norm(points, axis=1).max())


# ---- overlap


def test_overlap_of_hulls_and_boxes(rng):
    found, expected = [], []
    for _ in range(600):
        points = random_hull(rng), CUBE * rng.uniform(0.01, 0.3, 3)
        turn = Rotation.random(2, rng)
        at = rng.uniform(-0.1, 0.1, (2, 3))
        a = shape("hull", at[0], turn[0], points=points[0])
        b = shape("box", at[1], turn[1], size_m=np.ptp(points[1], axis=0))
        found.append(lib.convex_overlap_m(a, b))
        expected.append(hull_overlap_m(*(turn[k].apply(points[k]) + at[k] for k in range(2))))
    too_much = np.array(found) - expected
    assert 200 < np.count_nonzero(expected) < 550
    assert too_much.min() > -1e-9 and too_much.max() < OVERLAP_ERROR_M
    assert np.quantile(too_much, 0.98) < 3e-6


def test_overlap_of_round_shapes(rng):
    for _ in range(200):
        radius, length = rng.uniform(0.005, 0.08, 2), rng.uniform(0, 0.4)
        # Place a ball beside the middle of a cylinder's curved surface.
        turn, angle, depth = Rotation.random(rng=rng), rng.uniform(0, 6.3), rng.uniform(-0.01, 0.01)
        reach = radius.sum() - depth
        if length / 2 < 2 * depth + radius[1]:
            continue  # the shorter way out would be through the end face
        at = turn.apply([reach * np.cos(angle), reach * np.sin(angle), 0])
        cylinder = shape("cylinder", rotation=turn, length_m=length, radius_m=radius[0])
        ball = shape("capsule", at, radius_m=radius[1])
        assert -1e-9 < lib.convex_overlap_m(cylinder, ball) - max(depth, 0) < 0.2 * OVERLAP_ERROR_M


@pytest.mark.parametrize("depth_m", [-0.001, 0.0, 0.0005, 0.001, 0.0075])
def test_a_rod_on_a_stand(depth_m):
    """The overlap is correct for contact depths that occur in scenarios, and for a shape that lies inside another."""
    stand = shape("box", size_m=(0.06, 0.12, 0.04))
    along_y = Rotation.from_euler("x", 90, degrees=True)
    rod = shape("cylinder", (0, 0, 0.02 + 0.008 - depth_m), along_y, length_m=0.28, radius_m=0.008)
    assert lib.convex_overlap_m(stand, rod) == pytest.approx(max(depth_m, 0), abs=3e-6)
    assert lib.convex_overlap_m(rod, stand) == pytest.approx(max(depth_m, 0), abs=3e-6)
    inside = shape("cylinder", (0, 0, 0), along_y, length_m=0.28, radius_m=0.008)
    assert lib.convex_overlap_m(stand, inside) == pytest.approx(0.028, abs=3e-6)
