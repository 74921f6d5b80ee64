"""Particles interact correctly in one step: contacts agree with those that numpy finds among all pairs, and impulses
agree with statics and with the exact solution of the step's contact problem, from scipy."""

from __future__ import annotations

import numpy as np
import pytest
import water_binding
from scipy.optimize import nnls

G = 9.80665
STEP_S = 1e-3
MASS_KG = 2.5e-4


class Particles:
    """A particle_t[] that ends with the walls, viewed as arrays: ``position_m`` (n, 3), ``radius_m`` and ``mass_kg``
    (n,)."""

    def __init__(self, position_m, radius_m, mass_kg, walls=1):
        self.ffi, self.lib = water_binding.load()
        self.position_m, self.radius_m = np.array(position_m, float), np.array(radius_m, float)
        self.mass_kg, self.walls, self.count = np.array(mass_kg, float), walls, len(position_m)
        self.c = self.ffi.new("particle_t[]", self.count + walls)
        for i in range(self.count):
            self.c[i].radius_m, self.c[i].inverse_mass_pkg, self.c[i].cup = radius_m[i], 1 / mass_kg[i], -1
        self.place(self.position_m)

    def place(self, position_m):
        for i, position in enumerate(position_m):
            self.c[i].position_m = list(position)

    @property
    def velocity_mps(self) -> np.ndarray:
        return np.array([list(self.c[i].velocity_mps) for i in range(self.count)])

    @velocity_mps.setter
    def velocity_mps(self, values):
        for i, value in enumerate(values):
            self.c[i].velocity_mps = list(value)


class Solver:
    def __init__(self, particles):
        self.particles, self.ffi, self.lib = particles, particles.ffi, particles.lib
        create = self.lib.particle_solver_create(particles.count, particles.walls, MASS_KG)
        self.c = self.ffi.gc(create, self.lib.particle_solver_destroy)

    def step(self, contacts) -> np.ndarray:
        """Returns the impulses in N s. `contacts` lists (one, other, normal, depth_m, wall_speed_mps)."""
        c = self.ffi.new("particle_contact_t[]", [(*contact, 0.0) for contact in contacts])
        self.lib.particle_solver_step(self.c, c, len(contacts), self.particles.c, STEP_S)
        return np.array([c[i].impulse_Ns for i in range(len(contacts))])


def sizes(rng, count):
    radius_m = rng.uniform(0.8, 1.2, count) * 4e-3
    return radius_m, MASS_KG * (radius_m / 4e-3) ** 3


# ---- contacts


def contacts_of_all_pairs(position_m, radius_m, spilt):
    """Returns {(one, other): (normal, depth)} with one > other."""
    found = {}
    for one in np.flatnonzero(~spilt):
        for other in np.flatnonzero(~spilt[:one]):
            d = position_m[one] - position_m[other]
            depth = radius_m[one] + radius_m[other] - np.linalg.norm(d)
            if depth > 0:
                found[int(one), int(other)] = (d / np.linalg.norm(d), depth)
    return found


@pytest.mark.parametrize("way_m", [1e-4, 1e-3, 1e-2])
def test_contacts_match_those_of_all_pairs(rng, way_m):
    """The contacts found in a crowd of particles are those found by comparing all pairs, while the particles move by
    small or large steps and some of them spill."""
    count = 60
    radius_m, mass_kg = sizes(rng, count)
    particles = Particles(rng.uniform(-0.02, 0.02, (count, 3)), radius_m, mass_kg)
    ffi, lib = particles.ffi, particles.lib
    in_order, sorted_count = ffi.new("particle_along_x_t[]", count), ffi.new("int *", count)
    for i, index in enumerate(rng.permutation(count)):
        in_order[i].particle = int(index)
    contact, spilt, seen = ffi.new("particle_contact_t[]", count * count), np.zeros(count, bool), 0
    position_m = particles.position_m
    for step in range(20):
        position_m = position_m + rng.uniform(-way_m, way_m, (count, 3))
        particles.place(position_m)
        if step % 5 == 4:
            spilt[rng.integers(count)] = True
        for i in range(count):
            particles.c[i].is_spilt = bool(spilt[i])
        found = lib.particle_contacts_find(particles.c, in_order, sorted_count, contact)
        expected = contacts_of_all_pairs(position_m, radius_m, spilt)
        assert {(contact[i].one, contact[i].other) for i in range(found)} == set(expected)
        assert found == len(expected)
        for c in contact[0:found]:
            normal, depth_m = expected[c.one, c.other]
            assert list(c.normal) == pytest.approx(normal, abs=1e-12)
            assert (c.depth_m, c.wall_speed_mps) == pytest.approx((depth_m, 0.0), abs=1e-12)
        seen += found
    assert sorted_count[0] == count - spilt.sum()
    assert seen > 20


def test_wall_contacts_have_the_speed_of_the_wall():
    """For a particle in the corner of a cup that moves and turns, the wall's speed along each normal is that of the
    touched point, v + w x r."""
    ffi, lib = water_binding.load()
    cup = ffi.new("cup_t *", {"present": True, "radius_m": 0.03, "height_m": 0.04, "wall_m": 0.002})
    velocity, turn = np.array([0.2, -0.1, 0.3]), np.array([0.5, -0.4, 0.0])
    pose = ffi.new("rigid_pose_t[2]")
    pose[0].rotation = [1, 0, 0, 0]
    pose[1].position_m = list(velocity * STEP_S)
    pose[1].rotation = [1, *(turn * STEP_S / 2)]  # to first order
    before, after = ffi.new("placed_cup_t *"), ffi.new("placed_cup_t *")
    before[0], after[0] = lib.cup_place(cup, pose), lib.cup_place(cup, pose + 1)
    particles = Particles([[0.0265, 0.0, 0.0035]], [4e-3], [MASS_KG])
    contact = ffi.new("particle_contact_t[2]")
    found = lib.particle_contacts_find_cup(particles.c, 1, before, after, STEP_S, 7, contact)
    assert [(c.one, c.other) for c in contact[0:found]] == [(0, 7), (0, 8)]
    for c, normal, point in zip(contact, ([0, 0, 1], [-1, 0, 0]), ([0.0265, 0, 0], [0.03, 0, 0.0035]), strict=True):
        assert list(c.normal) == pytest.approx(normal, abs=1e-12)
        assert c.depth_m == pytest.approx(0.5e-3, abs=1e-12)
        assert c.wall_speed_mps == pytest.approx(normal @ (velocity + np.cross(turn, point)), abs=1e-4)


# ---- impulses


def crowd(rng, count=25):
    """Returns (particles, contacts, velocity_mps) of overlapping moving particles above a floor."""
    radius_m, mass_kg = sizes(rng, count)
    position_m = rng.uniform([-0.01, -0.01, 0.003], [0.01, 0.01, 0.02], (count, 3))
    particles = Particles(position_m, radius_m, mass_kg)
    found = contacts_of_all_pairs(position_m, radius_m, np.zeros(count, bool))
    contacts = [(one, other, list(normal), depth, 0.0) for (one, other), (normal, depth) in found.items()]
    contacts += [
        (i, count, [0.0, 0.0, 1.0], radius_m[i] - z, 0.1) for i, z in enumerate(position_m[:, 2]) if z < radius_m[i]
    ]
    return particles, contacts, rng.normal(0.0, 0.3, (count, 3))


def jacobian(particles, contacts) -> np.ndarray:
    """Returns the matrix (contacts, 3 n) that maps velocities to speeds along the normals."""
    rows = np.zeros((len(contacts), particles.count + 1, 3))
    for row, (one, other, normal, _, _) in zip(rows, contacts, strict=True):
        row[one] += normal
        row[other] -= normal
    return rows[:, :-1].reshape(len(contacts), -1)


def test_impulses_solve_the_soft_contacts_exactly(rng):
    """If its step is repeated with the same contacts and velocities, the solver converges to the solution of the
    complementarity problem 0 <= p, 0 <= (J M^-1 J' + s) p + J v - b. The matrix and the right-hand side are derived
    from two properties measured on a single contact: the speed that separates an overlap, and the fraction of the speed
    that remains."""
    particles, contacts, velocity = crowd(rng)
    solver = Solver(particles)
    j, per_kg = jacobian(particles, contacts), np.repeat(1 / particles.mass_kg, 3)
    # For one particle of mean mass on a wall, the impulse is p = (c depth - v) / (1/m + s).
    single = Particles([[0, 0, 0]], [4e-3], [MASS_KG])
    one = Solver(single)

    def converged(depth_m, v_mps):
        for _ in range(200):
            single.velocity_mps = [[0, 0, v_mps]]
            impulse = one.step([(0, 1, [0, 0, 1], depth_m, 0.0)])
        return impulse[0]

    softness = 1 / converged(0.0, -1.0) - 1 / MASS_KG
    parting = converged(1e-3, 0.0) / converged(0.0, -1.0) / 1e-3
    depth, wall_speed = np.array([c[3] for c in contacts]), np.array([c[4] for c in contacts])
    right = parting * depth + wall_speed - j @ velocity.ravel()
    matrix = (j * per_kg) @ j.T + softness * np.eye(len(contacts))
    factor = np.linalg.cholesky(matrix).T
    exact, _ = nnls(factor, np.linalg.solve(factor.T, right), maxiter=10000)
    for _ in range(3000):
        particles.velocity_mps = velocity
        impulses = solver.step(contacts)
    assert (exact > 0).sum() > 20
    assert (exact == 0).sum() > 5
    assert impulses == pytest.approx(exact, abs=1e-9 * exact.max())
    assert particles.velocity_mps.ravel() == pytest.approx(velocity.ravel() + per_kg * (exact @ j), abs=1e-9)


def test_momentum_is_conserved_except_at_the_walls(rng):
    """However far the impulses of one step are from the exact solution, only the floor's impulses change the total
    momentum."""
    particles, contacts, velocity = crowd(rng)
    solver = Solver(particles)
    particles.velocity_mps = velocity
    impulses = solver.step(contacts)
    on_wall = impulses[[c[1] == particles.count for c in contacts]].sum()
    change = particles.mass_kg @ (particles.velocity_mps - velocity)
    assert on_wall > 0
    assert change == pytest.approx([0, 0, on_wall], abs=1e-15)


def test_contacts_dissipate_energy(rng):
    """Contacts without overlap, between particles and with a fixed floor, dissipate energy in each of a hundred
    steps."""
    particles, contacts, velocity = crowd(rng)
    contacts = [(*c[:3], 0.0, 0.0) for c in contacts]
    solver = Solver(particles)
    particles.velocity_mps = velocity
    last = particles.mass_kg @ (velocity**2).sum(1) / 2
    first = last
    for _ in range(100):
        solver.step(contacts)
        energy = particles.mass_kg @ (particles.velocity_mps**2).sum(1) / 2
        assert energy <= last * (1 + 1e-12)
        last = energy
    assert last < 0.9 * first


def test_separating_contacts_get_no_impulse():
    particles = Particles([[0, 0, 0.01], [0, 0, 0]], [4e-3] * 2, [MASS_KG] * 2)
    particles.velocity_mps = [[0.3, 0, 0.2], [0, 0.1, -0.1]]
    assert Solver(particles).step([(1, 0, [0, 0, -1], 0.0, 0.0)]) == 0.0
    assert particles.velocity_mps.tolist() == [[0.3, 0, 0.2], [0, 0.1, -0.1]]


def test_an_interrupted_contact_starts_from_zero():
    """After a step without the contact, the solver returns the same impulse, bit for bit, as a solver that has never
    seen the contact. Without the interruption it returns a different impulse."""

    def impulse(*steps):
        particles = Particles([[0, 0, 7e-3], [0, 0, 0]], [4e-3] * 2, [MASS_KG] * 2)
        solver = Solver(particles)
        for contacts in steps:
            particles.velocity_mps = [[0, 0, -0.1], [0, 0, 0]]
            impulses = solver.step(contacts)
        return impulses[0]

    contact = [(1, 0, [0, 0, -1], 1e-3, 0.0)]
    assert impulse(contact, [], contact) == impulse(contact)
    assert impulse(contact, contact) != impulse(contact)


def test_a_stack_presses_with_its_weight(rng):
    """Each particle in a column of eight carries those above it, and the floor carries the whole column. Overlaps are
    proportional to the load."""
    count = 8
    radius_m, mass_kg = sizes(rng, count)
    z = np.cumsum(2 * radius_m) - radius_m
    particles = Particles([[0, 0, height] for height in z], radius_m, mass_kg)
    solver = Solver(particles)
    for _ in range(5000):
        overlap = np.append(radius_m[0] - z[0], radius_m[1:] + radius_m[:-1] - np.diff(z))
        others = [count, *range(count - 1)]
        contacts = [(i, others[i], [0, 0, 1], overlap[i], 0.0) for i in range(count) if overlap[i] > 0]
        particles.velocity_mps = particles.velocity_mps - [0, 0, G * STEP_S]
        impulses = solver.step(contacts)
        z = z + particles.velocity_mps[:, 2] * STEP_S
    weight_N = G * np.cumsum(mass_kg[::-1])[::-1]
    assert impulses / STEP_S == pytest.approx(weight_N, rel=1e-9)
    assert overlap / overlap[0] == pytest.approx(weight_N / weight_N[0], rel=1e-9)
