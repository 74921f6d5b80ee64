"""Checks the dual quaternion algebra against dqrobotics and numpy in double precision."""

from __future__ import annotations

from itertools import permutations, product

import dqrobotics
import numpy as np
import oracle
import pytest
from comanip import core
from comanip._core import ffi, lib

COUNT = 100_000


def test_decompositional_product_matches_dqrobotics_on_100_000_pairs(rng):
    a, b = oracle.random_poses(rng, COUNT), oracle.random_poses(rng, COUNT)
    expected = [
        dqrobotics.dec_mult(dqrobotics.DQ(x), dqrobotics.DQ(y)).vec8()
        for x, y in zip(oracle.unit(a), oracle.unit(b), strict=True)
    ]
    assert oracle.pose_distance(core.decompositional_multiply(a, b), np.array(expected)).max() < 2e-6


def test_decompositional_product_adds_translations_and_composes_rotations(rng):
    a, b = oracle.random_poses(rng, 1000), oracle.random_poses(rng, 1000)
    c = core.decompositional_multiply(a, b)
    assert np.abs(oracle.translation(c) - oracle.translation(a) - oracle.translation(b)).max() < 2e-6
    rotations = oracle.rotation_matrix(b[:, :4]) @ oracle.rotation_matrix(a[:, :4])
    assert np.abs(oracle.rotation_matrix(c[:, :4]) - rotations).max() < 2e-6


def test_decompositional_product_is_associative(rng):
    a, b, c = (oracle.random_poses(rng, 1000) for _ in range(3))
    left = core.decompositional_multiply(core.normalise(core.decompositional_multiply(a, b)), c)
    right = core.decompositional_multiply(a, core.normalise(core.decompositional_multiply(b, c)))
    assert oracle.pose_distance(left, right).max() < 2e-6


def test_multiply_and_conjugate_are_the_algebra_of_any_dual_quaternions(rng):
    a, b = (rng.normal(size=(COUNT, 8)).astype(np.float32) for _ in range(2))
    expected = oracle.multiply(a.astype(float), b.astype(float))
    assert (np.abs(core.multiply(a, b) - expected) / (1 + np.abs(expected))).max() < 5e-6
    assert np.array_equal(core.conjugate(a), oracle.conjugate(a.astype(float)).astype(np.float32))


def test_a_pose_times_its_conjugate_is_one(rng):
    a = oracle.random_poses(rng, COUNT)
    one = np.array([1, 0, 0, 0, 0, 0, 0, 0])
    assert np.abs(core.multiply(a, core.conjugate(a)) - one).max() < 1e-6


def test_normalise_gives_the_nearest_pose(rng):
    disturbed = (oracle.random_poses(rng, COUNT) + rng.normal(scale=0.05, size=(COUNT, 8))).astype(np.float32)
    result = core.normalise(disturbed)
    assert np.abs(result - oracle.unit(disturbed)).max() < 2e-6
    double = result.astype(float)
    assert np.abs(np.linalg.norm(double[:, :4], axis=1) - 1).max() < 2e-7
    assert np.abs((double[:, :4] * double[:, 4:]).sum(1)).max() < 2e-7


def test_renormalised_products_stay_unit_while_raw_ones_drift(rng):
    """In 100 chains of 10,000 products each, raw float32 products drift off the unit sphere and renormalised products
    stay on it."""
    steps = oracle.random_poses(rng, 10_000, 0.01)
    raw = renormalised = oracle.random_poses(rng, 100)
    for step in steps:
        factor = np.tile(step, (100, 1))
        raw = core.multiply(raw, factor)
        renormalised = core.normalise(core.multiply(renormalised, factor))

    def defect(x: np.ndarray) -> float:
        x = x.astype(float)
        return max(np.abs(np.linalg.norm(x[:, :4], axis=1) - 1).max(), np.abs((x[:, :4] * x[:, 4:]).sum(1)).max())

    assert defect(renormalised) < 1e-6 < defect(raw)


def edge_rotations() -> np.ndarray:
    """Returns the 24 rotations that map the coordinate axes onto each other, and half turns and nearly half turns about
    many axes."""
    signed = [np.diag(s) @ np.eye(3)[list(p)] for p in permutations(range(3)) for s in product((1, -1), repeat=3)]
    axis_aligned = [matrix for matrix in signed if np.linalg.det(matrix) > 0]
    axes = np.array([v for v in product((-1, -1e-3, 0, 1e-3, 1), repeat=3) if np.linalg.norm(v) > 0.5])
    angles = np.pi + np.array([0, 1e-7, -1e-7, 1e-4, -1e-4, 1e-2, -1e-2, np.pi - 1e-4])
    turns = [oracle.rotation_matrix(oracle.rotation(axis, angle)) for axis in axes for angle in angles]
    return np.array(axis_aligned + turns)


@pytest.mark.parametrize("kind", ["random", "edge"])
def test_pose_from_matrix_is_footnote_1(rng, kind):
    matrices = edge_rotations() if kind == "edge" else oracle.rotation_matrix(oracle.random_rotations(rng, COUNT))
    matrices = matrices.astype(np.float32)
    t = rng.uniform(-1, 1, (len(matrices), 3)).astype(np.float32)
    poses = core.pose_from_matrix(matrices, t)
    assert np.abs(oracle.rotation_matrix(poses[:, :4]) - matrices).max() < 1e-6
    assert np.abs(oracle.translation(poses) - t).max() < 1e-6
    assert (poses[:, 0] >= 0).all()
    assert np.abs(poses.astype(float) - oracle.unit(poses)).max() < 5e-7


@pytest.mark.parametrize("scale", [0.0, 1e-9, 1e-6, 1.1e-6, 1e-3, 1.0, 10.0, 36.0])
def test_quaternion_from_rotation_vector(rng, scale):
    for vector in (scale * rng.uniform(-1, 1, (500, 3))).astype(np.float32):
        got = lib.quaternion_from_rotation_vector(ffi.new("vector3_t *", vector.tolist())[0])
        angle = np.linalg.norm(vector.astype(float))
        expected = oracle.rotation(vector if angle else [1, 0, 0], angle)
        # the half angle is a float32, so its rounding error grows with the angle
        assert np.abs(np.array([got.w, got.x, got.y, got.z]) - expected).max() < 4e-7 + 1.2e-7 * angle


def test_interpolation_takes_the_shorter_arc(rng):
    for a, b in zip(oracle.random_rotations(rng, 500), oracle.random_rotations(rng, 500), strict=True):
        s = rng.uniform()
        got = [
            lib.quaternion_interpolate(*(ffi.new("quaternion_t *", q.tolist())[0] for q in pair), s)
            for pair in ((a, b), (a, -b))
        ]
        first, second = (np.array([q.w, q.x, q.y, q.z]) for q in got)
        assert np.abs(first - second).max() < 1e-6
        assert abs(np.linalg.norm(first) - 1) < 1e-6
        whole = oracle.rotation_angle(a, b)
        parts = oracle.rotation_angle(a, first) + oracle.rotation_angle(first, b)
        assert abs(parts - whole) < 5e-6  # the result lies on the shortest arc between them
