"""ODE's bodies against mechanics in numpy: the bare arm as a pendulum and as a free chain, momentum, free fall; and what
the step's length does to them."""

from __future__ import annotations

import contextlib
from typing import Any

import hoap3
import numpy as np
import plant_binding
import pytest
from scene_bench import ALONG_X, GRAVITY_MPS2, Scene
from scipy.integrate import solve_ivp

STEPS_S = (0.5e-3, 1e-3, 2e-3)


@pytest.fixture(scope="module")
def sim():
    return plant_binding.load()


@contextlib.contextmanager
def limp_arm(sim, q, limp_joints):
    """The arm in a world of its own, the motors of some joints without torque; the others hold."""
    ffi, lib = sim
    world = lib.physics_create()
    arm = lib.arm_plant_create(world, ffi.new("double[4]", list(q)))
    for joint in limp_joints:
        lib.arm_plant_release(arm, joint)
    try:
        yield world, arm
    finally:
        lib.arm_plant_destroy(arm)
        lib.physics_destroy(world)


def swing(sim, q, limp_joints, step_s, duration_s) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (N,) in s, joint angles and rates (N, 4) at the end of each step, from rest at q."""
    lib = sim[1]
    rows = []
    with limp_arm(sim, q, limp_joints) as (world, arm):
        for _ in range(round(duration_s / step_s)):
            lib.physics_step(world, step_s)
            rows.append(
                [lib.arm_plant_position_rad(arm, i) for i in range(4)]
                + [lib.arm_plant_velocity_radps(arm, i) for i in range(4)]
            )
    rows = np.array(rows)
    return step_s * np.arange(1, len(rows) + 1), rows[:, :4], rows[:, 4:]


def energy_J(q: np.ndarray, rates: np.ndarray) -> float:
    height = hoap3.centres_of_mass(q)[:, 2]
    return 0.5 * rates @ hoap3.inertia_matrix(q) @ rates + GRAVITY_MPS2 * hoap3.MASSES_KG @ height


def energies_J(start, angles, rates, every: int = 1) -> np.ndarray:
    """Semi-implicit steps know the rate in the middle of a step: the angles there are the mean of both ends."""
    middle = 0.5 * (np.vstack([start, angles[:-1]]) + angles)
    return np.array([energy_J(q, v) for q, v in zip(middle[::every], rates[::every], strict=True)])


def turning_times_s(times: np.ndarray, rate: np.ndarray) -> np.ndarray:
    i = np.flatnonzero(np.diff(np.sign(rate)))
    return times[i] - rate[i] * (times[i + 1] - times[i]) / (rate[i + 1] - rate[i])


# The elbow and the shoulder's other joints hold: 92 degrees to and fro about the hanging posture.
PENDULUM = np.radians([50, -20, 0, -20])


def pendulum(duration_s: float) -> Any:
    """The compound pendulum's large swing, integrated by scipy: angle and rate over time."""
    inertia = hoap3.inertia_matrix(PENDULUM)[0, 0]
    level, upright = (hoap3.holding_torque(np.r_[q, PENDULUM[1:]])[0] for q in (0.0, 0.5 * np.pi))

    def slope(_, y):
        return [y[1], -(level * np.cos(y[0]) + upright * np.sin(y[0])) / inertia]

    return solve_ivp(slope, (0, duration_s), [PENDULUM[0], 0], rtol=1e-10, atol=1e-12, dense_output=True).sol


@pytest.mark.parametrize("step_s", STEPS_S)
def test_the_arm_swings_as_a_compound_pendulum(sim, step_s):
    times, angles, rates = swing(sim, PENDULUM, [0], step_s, 5.0)
    exact = pendulum(6.0)
    fine = np.arange(1e-4, 5.0, 1e-4)
    expected = np.diff(turning_times_s(fine, exact(fine)[1]))
    measured = np.diff(turning_times_s(times - 0.5 * step_s, rates[:, 0]))
    assert 2 * expected.mean() == pytest.approx(0.8168, abs=1e-4) and len(measured) == len(expected) == 11
    assert np.abs(measured / expected - 1).max() < 0.1 * step_s  # 0.01 % at 1 ms
    assert angles[:, 0].max() == pytest.approx(exact(fine)[0].max(), abs=1.0 * step_s)
    assert np.abs(angles[:, 1:] - PENDULUM[1:]).max() < 1e-8  # what holds does hold


def test_a_pendulums_energy_drifts_less_with_smaller_steps(sim):
    """Over 10 s, against 0.39 J that go to and fro: below 0.2 % at 1 ms."""
    drifts = []
    for step_s in STEPS_S:
        _, angles, rates = swing(sim, PENDULUM, [0], step_s, 10.0)
        energies = energies_J(PENDULUM, angles, rates, every=round(0.038 / step_s))
        drifts.append(np.abs(energies - energy_J(PENDULUM, np.zeros(4))).max())
    assert drifts[0] < 0.6 * drifts[1] and drifts[1] < 0.6 * drifts[2]
    lowest = min(energy_J(np.r_[q, PENDULUM[1:]], np.zeros(4)) for q in np.radians(np.arange(50, 150)))
    assert drifts[1] < 0.002 * (energy_J(PENDULUM, np.zeros(4)) - lowest)


def accelerations(q: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Of the free chain: M(q) a = -(dM/dt v - 1/2 grad v'Mv) - gravity's torque."""
    e = 1e-5
    slope = np.array([hoap3.inertia_matrix(q + e * x) - hoap3.inertia_matrix(q - e * x) for x in np.eye(4)]) / (2 * e)
    bias = np.einsum("kij,k,j->i", slope, rates, rates) - 0.5 * np.einsum("ijk,j,k->i", slope, rates, rates)
    return np.linalg.solve(hoap3.inertia_matrix(q), -bias - hoap3.holding_torque(q))


@pytest.mark.parametrize("start_deg", [[60, -70, 20, -80], [0, -60, -30, -40]])
def test_all_joints_limp_is_a_four_link_chain(sim, start_deg):
    """Until just before the first stop. The error is half a step's way: halving with the step."""
    start, duration_s = np.radians(start_deg), 0.186
    exact = solve_ivp(
        lambda _, y: np.r_[y[4:], accelerations(y[:4], y[4:])],
        (0, duration_s), np.r_[start, np.zeros(4)], rtol=1e-6, atol=1e-7, dense_output=True,
    ).sol  # fmt: skip
    fastest = np.abs(exact(np.linspace(0, duration_s, 100))[4:]).max()
    errors, losses = [], []
    for step_s in STEPS_S:
        times, angles, rates = swing(sim, start, range(4), step_s, duration_s)
        errors.append(np.abs(angles - exact(times)[:4].T).max())
        energies = energies_J(start, angles, rates, every=round(0.006 / step_s))
        losses.append(np.abs(energies - energy_J(start, np.zeros(4))).max())
    assert np.abs(exact(duration_s)[:4] - start).max() > np.radians(50)
    assert errors[1] < 1.0 * fastest * STEPS_S[1]
    assert errors[0] < 0.6 * errors[1] and errors[1] < 0.6 * errors[2]
    assert losses[1] < 0.01 * 0.5  # 1 % of what was set free
    assert losses[0] < 0.6 * losses[1] and losses[1] < 0.6 * losses[2]


# ---- bodies apart from the arm


def test_a_free_rod_falls(sim):
    """Semi-implicit steps are ahead of the parabola by half a step's way and by nothing else."""
    with Scene(objects=[{"kind": sim[1].OBJECT_ROD, "pose": ([0.4, 0.2, 0.5], [1, 0, 0, 0])}]) as scene:
        start, rotation = scene.thing()
        for steps in (1, 99, 200):
            scene.step(steps)
            fallen = 0.5 * GRAVITY_MPS2 * scene.now_s**2
            ahead = 0.5 * GRAVITY_MPS2 * scene.now_s * scene.step_s
            at, turned = scene.thing()
            assert start[2] - at[2] == pytest.approx(fallen + ahead, rel=1e-9)
            assert np.abs(at[:2] - start[:2]).max() < 1e-12
            assert (turned * rotation.inv()).magnitude() < 1e-12


def test_inner_forces_change_no_momentum(sim):
    """Gravity off, a limp arm (no stiffness) holds a rod by its end: a push on the hand, then nothing. Hand and rod keep the
    push's momentum and angular momentum together while the rod turns in the hand."""
    lib = sim[1]
    hand_kg, rod_kg, push_mps = 1.5, 0.5, np.array([0.0, 0.3, 0.4])  # what the push gives a hand without a rod
    across_kgm2 = rod_kg * (3 * 0.008**2 + 0.3**2) / 12
    person = {"mass_kg": hand_kg, "stiffness_Npm": 0.0, "stiffness_Nmprad": 0.0}
    rod = {"kind": lib.OBJECT_ROD, "pose": ([0.53, 0.2, 0.0], ALONG_X), "mass_kg": rod_kg}
    with Scene([person], [rod]) as scene:
        scene.set_gravity(0.0)
        assert scene.grip()
        (origin, _), (middle, turn) = scene.hand(), scene.thing()
        hand, direction, turned_rad = origin, turn.apply([0, 0, 1]), 0.0
        for step in range(1, 1001):
            scene.aim(0, origin + push_mps * scene.step_s * step)
            scene.step()
            v_hand = (scene.hand()[0] - hand) / scene.step_s  # ODE's own: it moves a body by its velocity times the step
            v_rod = (scene.thing()[0] - middle) / scene.step_s
            spin = np.cross(direction, scene.thing()[1].apply([0, 0, 1])) / scene.step_s
            assert np.allclose(hand_kg * v_hand + rod_kg * v_rod, hand_kg * push_mps, atol=1e-9)
            # About the hand's first place: the push went through it.
            moment = np.cross(hand - origin, hand_kg * v_hand) + np.cross(middle - origin, rod_kg * v_rod)
            assert np.abs(moment + across_kgm2 * spin).max() < 0.002 * rod_kg * 0.13 * 0.5
            hand, middle, direction = scene.hand()[0], scene.thing()[0], scene.thing()[1].apply([0, 0, 1])
            turned_rad += np.linalg.norm(spin) * scene.step_s
        assert turned_rad > 1.0
