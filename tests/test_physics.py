"""ODE's world agrees with analytic mechanics and numpy (hoap3.py) in energy, momentum, and motion of arm, rods and
crank, and its errors shrink with the step."""

from __future__ import annotations

import contextlib

import hoap3
import numpy as np
import pytest
from scene_bench import ALONG_X, ALONG_Y, CRANK, GRAVITY_MPS2, ROD, Scene, ffi, lib
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

STEPS_S = (0.5e-3, 1e-3, 2e-3)
HAND_M = np.array([0.4, 0.2, 0.0])


class BareArm:
    """The arm alone in its world, with its motors on."""

    def __init__(self, world, q):
        self.world = world
        self.plant = lib.arm_plant_create(world, ffi.new("double[4]", list(q)))

    def release(self, *joints: int) -> None:
        for joint in joints:
            lib.arm_plant_release(self.plant, joint)

    def run(self, duration_s: float, step_s: float, every_s: float = 0.01) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Returns times (N,), angles and rates (N, 4), one row per `every_s`."""
        steps, rows = round(every_s / step_s), round(duration_s / every_s)
        q, rate = np.zeros((rows, 4)), np.zeros((rows, 4))
        for i in range(rows):
            for _ in range(steps):
                lib.physics_step(self.world, step_s)
            for joint in range(4):
                q[i, joint] = lib.arm_plant_position_rad(self.plant, joint)
                rate[i, joint] = lib.arm_plant_velocity_radps(self.plant, joint)
        return every_s * np.arange(1, rows + 1), q, rate


@contextlib.contextmanager
def bare_arm(q, gravity=True):
    world = lib.physics_create()
    if not gravity:
        lib.dWorldSetGravity(world, 0, 0, 0)
    arm = BareArm(world, q)
    try:
        yield arm
    finally:
        lib.arm_plant_destroy(arm.plant)
        lib.physics_destroy(world)


def energy_J(q, rate, gravity=True) -> float:
    height = hoap3.MASSES_KG @ hoap3.centres_of_mass(q)[:, 2]
    return 0.5 * rate @ hoap3.inertia_matrix(q) @ rate + (GRAVITY_MPS2 * height if gravity else 0.0)


# ---- the bare arm


PENDULUM_START = np.radians([50, -5, 0, -30])  # the equilibrium is near 98 degrees; the stops are at -91 and 151


def pendulum(duration_s: float, step_s: float):
    with bare_arm(PENDULUM_START) as arm:
        arm.release(0)
        return arm.run(duration_s, step_s)


def compound_pendulum(t: np.ndarray) -> np.ndarray:
    """Returns the shoulder pitch over time, computed with numpy's inertia and gravity torque while the other joints are
    locked. The inertia about the shoulder's axis does not depend on the shoulder's angle. The amplitude is too large
    for a small-angle formula."""
    inertia = hoap3.inertia_matrix(PENDULUM_START)[0, 0]

    def motion(_, state):
        q = PENDULUM_START.copy()
        q[0] = state[0]
        return [state[1], -hoap3.holding_torque(q)[0] / inertia]

    return solve_ivp(motion, (0, t[-1]), [PENDULUM_START[0], 0.0], t_eval=t, rtol=1e-8, atol=1e-10).y[0]


def test_arm_swings_as_a_compound_pendulum():
    t, q, _ = pendulum(3.0, 1e-3)
    assert np.ptp(q[:, 0]) > np.radians(90)
    assert np.abs(q[:, 0] - compound_pendulum(t)).max() < 0.01
    assert np.abs(q[:, 1:] - PENDULUM_START[1:]).max() < 1e-3  # the motors hold the other joints


def test_pendulums_energy_does_not_drift_and_its_error_shrinks_with_the_step():
    inertia = hoap3.inertia_matrix(PENDULUM_START)[0, 0]
    ripple, drift = [], []
    for step_s in STEPS_S:
        t, q, rate = pendulum(10.0, step_s)
        e = np.array([energy_J(a, b) for a, b in zip(q, rate, strict=True)])
        swing_J = 0.5 * inertia * np.abs(rate[:, 0]).max() ** 2
        early, late = e[t < 2], e[t > 8]
        ripple.append(np.ptp(early) / swing_J)
        drift.append(abs(late.mean() - early.mean()) / swing_J)
    assert ripple[0] < 0.6 * ripple[1] < 0.36 * ripple[2] and ripple[2] < 0.02
    assert max(drift) < 3e-4


def lagrange(start: np.ndarray, duration_s: float) -> np.ndarray:
    """Returns the angles (4,) of the arm with all joints free, `duration_s` after release from rest, computed from
    Hamilton's equations in numpy."""

    def motion(_, state):
        q, momentum = state[:4], state[4:]
        rate = np.linalg.solve(hoap3.inertia_matrix(q), momentum)
        slope = np.zeros(4)
        for i in range(4):
            ahead, behind = q.copy(), q.copy()
            ahead[i] += 1e-5
            behind[i] -= 1e-5
            change = hoap3.inertia_matrix(ahead) - hoap3.inertia_matrix(behind)
            slope[i] = 0.5 * rate @ change @ rate / 2e-5
        return [*rate, *(slope - hoap3.holding_torque(q))]

    return solve_ivp(motion, (0, duration_s), [*start, 0, 0, 0, 0], rtol=1e-6, atol=1e-8).y[:4, -1]


@pytest.mark.parametrize("start_deg", [(60, -40, 10, -60), (0, -60, -30, -40)])
def test_free_chain_falls_as_lagrange_predicts(start_deg):
    """With all four joints free, the arm falls as predicted until shortly before it reaches its stops. The error
    shrinks with the step."""
    start, duration_s = np.radians(start_deg), 0.15
    expected, error = lagrange(start, duration_s), []
    for step_s in STEPS_S:
        with bare_arm(start) as arm:
            arm.release(0, 1, 2, 3)
            _, q, rate = arm.run(duration_s, step_s)
        error.append(np.abs(q[-1] - expected).max())
        assert energy_J(q[-1], rate[-1]) == pytest.approx(energy_J(start, np.zeros(4)), abs=2 * step_s)
    assert np.abs(expected - start).max() > 0.5
    assert error[0] < 0.6 * error[1] < 0.36 * error[2] and error[1] < 0.006


def test_chain_without_gravity_keeps_energy_and_angular_momentum():
    """Without gravity, no torque acts about the first joint's axis. All four joints coast, at least 10 degrees away
    from their stops."""
    lost, turned = [], []
    for step_s in STEPS_S:
        with bare_arm(np.radians([0, -50, 0, -60]), gravity=False) as arm:
            for joint, velocity in enumerate([1.0, -0.4, 0.5, -0.4]):
                lib.arm_plant_set_velocity(arm.plant, joint, velocity)
            arm.run(0.1, step_s)
            arm.release(0, 1, 2, 3)
            _, q, rate = arm.run(0.4, step_s)
        assert (np.degrees(q) > hoap3.STOPS_DEG[:, 0] + 10).all() and (np.degrees(q) < hoap3.STOPS_DEG[:, 1] - 10).all()
        e = np.array([energy_J(a, b, gravity=False) for a, b in zip(q, rate, strict=True)])
        about = np.array([(hoap3.inertia_matrix(a) @ b)[0] for a, b in zip(q, rate, strict=True)])
        lost.append(np.abs(e - e[0]).max() / e[0])
        turned.append(np.abs(about - about[0]).max() / about[0])
    assert lost[0] < 0.6 * lost[1] < 0.36 * lost[2] and lost[1] < 3e-4
    assert turned[0] < 0.6 * turned[1] < 0.36 * turned[2] and turned[1] < 5e-4


# ---- rods


@pytest.mark.parametrize("step_s", STEPS_S)
def test_rod_falls_as_galileo_predicts(step_s):
    tilted = list(Rotation.from_rotvec([0.5, 0.2, 0]).as_quat(scalar_first=True))
    rod = {"kind": lib.OBJECT_ROD, "pose": ([0.5, 0.5, 0.2], tilted)}
    with Scene([], [rod], step_s=step_s) as scene:
        scene.step(round(0.25 / step_s))
        fallen_m = 0.2 - scene.thing()[0][2]
        assert scene.thing()[1].as_quat(scalar_first=True) == pytest.approx(tilted, abs=1e-12)
    assert fallen_m == pytest.approx(0.5 * GRAVITY_MPS2 * 0.25**2, abs=0.51 * GRAVITY_MPS2 * 0.25 * step_s)


@pytest.mark.parametrize("kind", [lib.GRIP_BALL, lib.GRIP_FIXED])
def test_impulse_of_hand_and_weight_is_the_rods_momentum(kind):
    """When a hand swings the rod in all directions, the impulse of its weight and of the force that ODE reports for the
    hand equals the rod's change of momentum."""
    rod = {"kind": lib.OBJECT_ROD, "pose": (list(HAND_M + [0, 0.05, 0]), ALONG_Y), "person_grip": kind}
    with Scene([{}], [rod]) as scene:
        assert scene.grip()
        scene.step(1)
        place, impulse, velocity = [scene.thing()[0]], np.zeros(3), []
        for tick in range(1500):
            t = tick * scene.step_s
            scene.aim(0, HAND_M + 0.08 * np.sin([6 * t, 9 * t, 7 * t]))
            scene.step()
            place.append(scene.thing()[0])
            velocity.append((place[-1] - place[-2]) / scene.step_s)
            if tick > 0:
                impulse += (-scene.hand_force() - [0, 0, ROD["mass_kg"] * GRAVITY_MPS2]) * scene.step_s
                assert impulse == pytest.approx(ROD["mass_kg"] * (velocity[-1] - velocity[0]), abs=1e-9)
    assert np.abs(velocity).max() > 0.5


def test_two_hands_on_one_rod_act_and_react():
    """Without gravity, the part of one hand's impulse that does not change the rod's momentum acts on the other
    hand."""
    people = [{"start": (list(HAND_M + [0, y, 0]), [1, 0, 0, 0])} for y in (-0.1, 0.1)]
    with Scene(people, [{"kind": lib.OBJECT_ROD, "pose": (list(HAND_M), ALONG_Y)}]) as scene:
        scene.set_gravity(0.0)
        assert scene.grip(0) and scene.grip(1)
        scene.step(1)
        place = [scene.thing()[0]]
        velocity, largest_N = np.zeros(3), 0.0
        for tick in range(1000):
            t = tick * scene.step_s
            scene.aim(0, HAND_M + [0.02 * np.sin(8 * t), -0.1 - 0.01 * np.sin(5 * t), 0.02 * np.sin(6 * t)])
            scene.step()
            place.append(scene.thing()[0])
            before, velocity = velocity, (place[-1] - place[-2]) / scene.step_s
            if tick > 0:
                given_N = -scene.hand_force(0) - scene.hand_force(1)
                assert given_N * scene.step_s == pytest.approx(ROD["mass_kg"] * (velocity - before), abs=1e-9)
            largest_N = max(largest_N, np.linalg.norm(scene.hand_force(0)))
    assert largest_N > 1.0


def test_internal_forces_do_not_change_the_momentum():
    """A limp arm (no stiffness) holds a rod by its end, and the hand is pushed once. Hand and rod together keep the
    momentum and angular momentum of the push while the rod turns in the hand."""
    # push_mps: the speed that the push would give a hand without a rod
    hand_kg, rod_kg, push_mps = 1.5, 0.5, np.array([0.0, 0.3, 0.4])
    across_kgm2 = rod_kg * (3 * ROD["radius_m"] ** 2 + ROD["length_m"] ** 2) / 12
    person = {"mass_kg": hand_kg, "stiffness_Npm": 0.0, "stiffness_Nmprad": 0.0}
    rod = {"kind": lib.OBJECT_ROD, "pose": ([0.53, 0.2, 0.0], ALONG_X), "mass_kg": rod_kg}
    with Scene([person], [rod]) as scene:
        scene.set_gravity(0.0)
        assert scene.grip()
        origin, (middle, turn) = scene.hand()[0], scene.thing()
        hand, direction, turned_rad = origin, turn.apply([0, 0, 1]), 0.0
        for step in range(1, 1001):
            scene.aim(0, origin + push_mps * scene.step_s * step)
            scene.step()
            # velocities from displacements, because ODE moves a body by velocity times step
            v_hand = (scene.hand()[0] - hand) / scene.step_s
            v_rod = (scene.thing()[0] - middle) / scene.step_s
            spin = np.cross(direction, scene.thing()[1].apply([0, 0, 1])) / scene.step_s
            assert np.allclose(hand_kg * v_hand + rod_kg * v_rod, hand_kg * push_mps, atol=1e-9)
            # moments about the hand's initial position, where the push was applied
            moment = np.cross(hand - origin, hand_kg * v_hand) + np.cross(middle - origin, rod_kg * v_rod)
            assert np.abs(moment + across_kgm2 * spin).max() < 0.002 * rod_kg * 0.13 * 0.5
            hand, middle, direction = scene.hand()[0], scene.thing()[0], scene.thing()[1].apply([0, 0, 1])
            turned_rad += np.linalg.norm(spin) * scene.step_s
        assert turned_rad > 1.0


# ---- the crank


CRANK_RADIUS_M = 0.05
# Inertia about the hinge of a cylinder of 10 mm radius at the handle. The cylinder turns with the crank's arm.
CRANK_INERTIA = CRANK["mass_kg"] * (0.5 * 0.01**2 + CRANK_RADIUS_M**2)
HINGE_M = np.array([0.5, 0.2, 0.0])


def crank(**fields) -> dict:
    """Returns a crank with its hinge along y and its handle on the +x side."""
    return {"kind": lib.OBJECT_CRANK, "pose": (list(HINGE_M), ALONG_Y), "radius_m": CRANK_RADIUS_M, **fields}


def handle(angle_rad: float) -> np.ndarray:
    """Returns the handle's position on its circle. A positive turn about +y takes +x to -z."""
    return HINGE_M + CRANK_RADIUS_M * np.array([np.cos(angle_rad), 0, -np.sin(angle_rad)])


def angle_of(scene: Scene) -> float:
    return 2 * np.pi * lib.scene_crank_turns(scene.scene, 0)


def test_persons_work_on_the_crank_equals_the_friction_losses():
    """Over one and a half turns of a crank with weight, from rest to rest, the person's work equals the viscous losses,
    the dry-friction losses and the potential energy gained."""
    damping, friction = 0.02, 0.05
    person = {"start": (list(handle(0)), [1, 0, 0, 0]), "stiffness_Npm": 800.0, "damping_ratio": 1.0}
    with Scene([person], [crank(damping_Nmspprad=damping, friction_Nm=friction)]) as scene:
        assert scene.grip()
        work_J = viscous_J = dry_J = 0.0
        before_m, before_rad = scene.hand()[0], 0.0
        for tick in range(5000):
            s = min(1.0, tick / 4000)
            scene.aim(0, handle(3 * np.pi * s**3 * (10 - 15 * s + 6 * s**2)))
            scene.step()
            at_m, angle = scene.hand()[0], angle_of(scene)
            rate = (angle - before_rad) / scene.step_s
            viscous_J += damping * rate**2 * scene.step_s
            dry_J += friction * abs(rate) * scene.step_s
            work_J -= scene.hand_force() @ (at_m - before_m)
            before_m, before_rad = at_m, angle
        height_m = scene.point("POINT_OBJECT", 0, 0)[2] - HINGE_M[2]
    assert before_rad == pytest.approx(3 * np.pi, abs=0.05)
    potential_J = CRANK["mass_kg"] * GRAVITY_MPS2 * height_m
    assert min(viscous_J, dry_J) > 0.3
    assert work_J == pytest.approx(viscous_J + dry_J + potential_J, rel=0.01)


def spin_down(rate_radps: float, duration_s: float, **fields) -> np.ndarray:
    """Returns the angles (N,), one per ms, of a crank that is released without gravity at the given rate."""
    person = {"start": (list(handle(0)), [1, 0, 0, 0]), "stiffness_Npm": 800.0}
    with Scene([person], [crank(**fields)]) as scene:
        scene.set_gravity(0.0)
        assert scene.grip()
        for tick in range(600):  # 0.2 s of acceleration, 0.4 s at the final rate
            t = tick * scene.step_s
            scene.aim(0, handle(rate_radps * (0.5 * t * t / 0.2 if t < 0.2 else t - 0.1)))
            scene.step()
        lib.scene_open_hand(scene.scene, 0)
        angles = []
        for _ in range(round(duration_s / scene.step_s)):
            scene.step()
            angles.append(angle_of(scene))
    return np.array(angles)


@pytest.mark.parametrize("damping", [0.0005, 0.005, 2.0])  # at 2.0, the time constant is far shorter than a step
def test_viscous_crank_slows_down_exponentially(damping):
    angles = spin_down(6.0, 1.0, damping_Nmspprad=damping)
    rate = np.diff(angles) / 1e-3
    t = 1e-3 * np.arange(len(rate))
    expected = rate[0] * np.exp(-t * damping / CRANK_INERTIA)
    assert np.abs(rate - expected).max() < 0.01 * abs(rate[0]) + 1e-9


def test_dry_crank_slows_down_linearly_and_stops():
    friction = 0.003
    rate = np.diff(spin_down(6.0, 1.0, friction_Nm=friction)) / 1e-3
    t = 1e-3 * np.arange(len(rate))
    expected = np.maximum(0.0, rate[0] - t * friction / CRANK_INERTIA)
    assert expected[-1] == 0.0 and rate[0] > 1.0
    assert np.abs(rate - expected).max() < 0.01 * rate[0]


def test_loose_crank_swings_as_a_pendulum():
    with Scene([], [crank()]) as scene:
        angles = []
        for _ in range(3000):
            scene.step()
            angles.append(angle_of(scene))
    torque = CRANK["mass_kg"] * GRAVITY_MPS2 * CRANK_RADIUS_M

    def motion(_, s):
        return [s[1], torque / CRANK_INERTIA * np.cos(s[0])]

    t = 1e-3 * np.arange(3000)  # the turn count lags by one step
    expected = solve_ivp(motion, (0, 3.0), [0.0, 0.0], t_eval=t, rtol=1e-9, atol=1e-9).y[0]
    assert np.ptp(expected) > 3.1
    assert np.abs(np.array(angles) - expected).max() < 0.05
