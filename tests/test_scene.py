"""Hands, grips, the gripper and objects of the physical scene behave as statics and dynamics computed by hand
predict."""

from __future__ import annotations

import numpy as np
import pytest
from scene_bench import ALONG_X, ALONG_Y, GRAVITY_MPS2, GRIPPER, PERSON, ROD, STAND, Scene, ffi, lib
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

HAND_M = np.array(PERSON["start"][0])
WEIGHT_N = ROD["mass_kg"] * GRAVITY_MPS2
UP = np.array([0.0, 0.0, 1.0])


def gripper_at() -> np.ndarray:
    """Returns the middle of the gripper at the arm's start, (3,), in m."""
    with Scene() as scene:
        return scene.point("POINT_ROBOT_GRIPPER")


def rod_at(position_m, axis=ALONG_Y, **fields) -> dict:
    return {"kind": lib.OBJECT_ROD, "pose": (list(position_m), axis), **fields}


def person_at(position_m, **fields) -> dict:
    return {"start": (list(position_m), [1, 0, 0, 0]), **fields}


def rod_on_stand(middle_m, axis=ALONG_Y, **fields) -> list[dict]:
    """Returns a rod, listed first, and a stand whose top touches it."""
    below_m = 0.5 * STAND["size_m"][2] + ROD["radius_m"]
    stand = {"kind": lib.OBJECT_STAND, "pose": (list(np.array(middle_m) - below_m * UP), [1, 0, 0, 0])}
    return [rod_at(middle_m, axis, **fields), stand]


@pytest.fixture
def ode_messages():
    """Collects the messages that ODE reports."""
    messages = []
    listener = ffi.callback("dMessageFunction", lambda _number, text, _arguments: messages.append(ffi.string(text)))
    lib.dSetMessageHandler(listener)
    yield messages
    lib.dSetMessageHandler(ffi.NULL)


# ---- a hand


def test_free_hand_is_exactly_where_it_is_aimed():
    with Scene([{}]) as scene:
        for tick in range(2000):
            t = (tick + 1) * scene.step_s
            position = HAND_M + 0.2 * np.sin([7 * t, 11 * t, 13 * t])
            turn = Rotation.from_rotvec(np.sin([3 * t, 5 * t, 4 * t]))
            scene.aim(0, position, turn.as_quat(scalar_first=True))
            scene.step()
            at, rotation = scene.hand()
            assert np.abs(at - position).max() < 1e-9
            assert (rotation.inv() * turn).magnitude() < 1e-7


@pytest.mark.parametrize("stiffness_Npm", [100.0, 800.0])
def test_weight_bends_the_arm_by_weight_over_stiffness(stiffness_Npm):
    with Scene([{"stiffness_Npm": stiffness_Npm}], [{"kind": lib.OBJECT_ROD}]) as scene:
        assert scene.grip()
        scene.step(5000)
        assert scene.hand()[0] == pytest.approx(HAND_M - WEIGHT_N / stiffness_Npm * UP, abs=1e-6)
        assert scene.hand_force() == pytest.approx(-WEIGHT_N * UP, abs=1e-4)


def test_lever_bends_the_wrist_by_torque_over_stiffness():
    lever_m = 0.1
    rod = rod_at(HAND_M + [0, lever_m, 0], person_grip=lib.GRIP_FIXED)
    with Scene([{"stiffness_Nmprad": 3.0}], [rod]) as scene:
        assert scene.grip()
        scene.step(8000)
        turn = scene.hand()[1].as_rotvec()
        # The rod hangs on a lever arm that turns with the hand, so its torque depends on the angle.
        expected = solve_angle(lambda angle: 3.0 * angle - WEIGHT_N * lever_m * np.cos(angle))
        assert turn == pytest.approx([-expected, 0, 0], abs=1e-5)


def solve_angle(excess, low=0.0, high=1.0):
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if excess(middle) > 0 else (middle, high)
    return low


@pytest.mark.parametrize("damping_ratio", [0.1, 0.7])
def test_arm_moves_as_a_damped_oscillator(damping_ratio):
    """When gravity is switched off, the hand with its rod oscillates about its aim."""
    rod_kg = 0.4
    with Scene([{"damping_ratio": damping_ratio}], [{"kind": lib.OBJECT_ROD, "mass_kg": rod_kg}]) as scene:
        assert scene.grip()
        scene.step(9000)
        sag_m = rod_kg * GRAVITY_MPS2 / PERSON["stiffness_Npm"]
        scene.set_gravity(0.0)
        measured = []
        for _ in range(800):
            scene.step()
            measured.append(scene.hand()[0][2] - HAND_M[2])
    mass, k = PERSON["mass_kg"] + rod_kg, PERSON["stiffness_Npm"]
    d = 2 * damping_ratio * np.sqrt(k * PERSON["mass_kg"])
    t = 1e-3 * np.arange(1, 801)
    swing = solve_ivp(lambda _, s: [s[1], -(k * s[0] + d * s[1]) / mass], (0, 0.81), [-sag_m, 0], t_eval=t, rtol=1e-9)
    assert np.abs(np.array(measured) - swing.y[0]).max() < 0.01 * sag_m


# ---- a person's grip


def test_hand_closes_on_what_is_within_25_mm():
    for distance_m, closes in ((0.024, True), (0.026, False)):
        with Scene([{}], [rod_at(HAND_M + [distance_m, 0, 0])]) as scene:
            assert scene.grip() is closes
            assert scene.times("person0.holds") == int(closes)
            assert lib.scene_holds(scene.scene, 0, 0) is closes
            scene.step()
            assert np.linalg.norm(scene.hand_force()) < 2 * WEIGHT_N  # there is no sudden pull


def test_two_people_share_a_rods_weight_by_the_lever_rule():
    a, b = 0.14, 0.06  # distances from the rod's middle
    people = [person_at(HAND_M - [0, a, 0]), person_at(HAND_M + [0, b, 0])]
    with Scene(people, [rod_at(HAND_M)]) as scene:
        assert scene.grip(0) and scene.grip(1)
        scene.step(8000)
        # The unequal sag tilts the rod by 0.2 degrees, which changes lever arms and heights only to second order.
        assert scene.hand_force(0)[2] == pytest.approx(-WEIGHT_N * b / (a + b), rel=1e-3)
        assert scene.hand_force(1)[2] == pytest.approx(-WEIGHT_N * a / (a + b), rel=1e-3)


def test_ball_grip_lets_the_wrist_turn_and_a_fixed_one_does_not():
    turn = Rotation.from_rotvec([0.3, 0, 0])
    for kind, turned_rad in ((lib.GRIP_BALL, 0.0), (lib.GRIP_FIXED, 0.3)):
        with Scene([{}], [rod_at(HAND_M, person_grip=kind)]) as scene:
            scene.set_gravity(0.0)
            before = scene.thing()[1]
            assert scene.grip()
            for tick in range(1000):
                part = Rotation.from_rotvec(turn.as_rotvec() * (tick + 1) / 1000)
                scene.aim(0, HAND_M, part.as_quat(scalar_first=True))
                scene.step()
            scene.step(2000)
            assert (scene.thing()[1] * before.inv()).magnitude() == pytest.approx(turned_rad, abs=1e-3)


@pytest.mark.parametrize("limit_N", [5.0, 20.0])
def test_persons_grip_slips_at_its_limit(limit_N):
    """When two people slowly pull on one rod, the weaker grip slips at its force limit."""
    people = [person_at(HAND_M), person_at(HAND_M + [0, 0.1, 0], grip_force_limit_N=limit_N)]
    with Scene(people, [rod_at(HAND_M)]) as scene:
        scene.set_gravity(0.0)
        assert scene.grip(0) and scene.grip(1)
        pull_N = 0.0
        while scene.times("person1.lost") == 0 and scene.now_s < 8:
            scene.aim(1, HAND_M + [0, 0.1 + 0.03 * scene.now_s, 0])
            pull_N = np.linalg.norm(scene.hand_force(1))
            scene.step()
        assert pull_N == pytest.approx(limit_N, rel=0.01)
        # The two arms are springs in series: each stretches by force / stiffness.
        assert 0.03 * scene.now_s == pytest.approx(2 * limit_N / PERSON["stiffness_Npm"], rel=0.1)
        assert not lib.scene_holds(scene.scene, 1, 0) and scene.times("person0.lost") == 0


def test_a_grip_beside_the_axis_causes_no_sudden_pull():
    with Scene([person_at(HAND_M + [0.01, 0, 0])], [rod_at(HAND_M)]) as scene:
        scene.set_gravity(0.0)
        assert scene.grip()
        for _ in range(200):
            scene.step()
            assert np.linalg.norm(scene.hand_force()) < 1e-9
        assert np.abs(scene.thing()[0] - HAND_M).max() < 1e-12


# ---- the robot's gripper


def test_gripper_closes_within_its_stroke_on_nothing():
    with Scene() as scene:
        assert lib.scene_gripper_opening(scene.scene) == 1.0
        lib.scene_command_gripper(scene.scene, True)
        scene.step(150)
        assert lib.scene_gripper_opening(scene.scene) == pytest.approx(0.5, abs=1e-9)
        scene.step(160)
        assert scene.first_s("robot.closed") == pytest.approx(GRIPPER["stroke_s"], abs=2e-3)
        lib.scene_command_gripper(scene.scene, False)
        scene.step(310)
        assert scene.first_s("robot.opened") == pytest.approx(0.31 + GRIPPER["stroke_s"], abs=2e-3)
        assert scene.times("robot.holds") == 0


@pytest.mark.parametrize(("share_of_capture", "holds"), [(0.9, True), (1.1, False)])
def test_gripper_holds_what_lies_between_its_jaws(share_of_capture, holds):
    aside_m = share_of_capture * GRIPPER["capture_m"]
    with Scene([], rod_on_stand(gripper_at() + [aside_m, 0, 0])) as scene:
        lib.scene_command_gripper(scene.scene, True)
        scene.step(400)
        assert lib.scene_robot_holds(scene.scene) is holds
        assert scene.times("robot.holds") == int(holds) and scene.times("robot.closed") == int(not holds)
        assert (lib.scene_gripper_opening(scene.scene) > 0.0) is holds


def test_pads_deflect_by_force_over_stiffness():
    """The middle of the rod is below the gripper's middle by the deflection of the pads, because the arm itself does
    not yield."""
    with Scene([], [rod_at(gripper_at(), held_by_robot=True)], gripper={"stiffness_Npm": 400.0}) as scene:
        scene.step(2000)
        sag_m = scene.thing()[0] - scene.point("POINT_ROBOT_GRIPPER")
        assert sag_m == pytest.approx(-WEIGHT_N / 400.0 * UP, abs=2e-5)
        assert lib.scene_gripper_force_N(scene.scene) == pytest.approx(WEIGHT_N, rel=1e-3)
        assert scene.times("robot.lost") == 0


@pytest.mark.parametrize("limit_N", [5.0, 12.0])  # at higher limits the arm's motors would yield first
def test_robots_grip_slips_at_its_limit_and_not_before(limit_N):
    at = gripper_at()
    hand = at + [0, 0.1, 0]
    with Scene([person_at(hand)], [rod_at(at, held_by_robot=True)], gripper={"force_limit_N": limit_N}) as scene:
        scene.set_gravity(0.0)
        assert scene.grip()
        pull_N = 0.0
        while scene.times("robot.lost") == 0 and scene.now_s < 10:
            scene.aim(0, hand + [0, 0.02 * scene.now_s, 0])
            pull_N = np.linalg.norm(scene.hand_force())
            scene.step()
            assert lib.scene_gripper_force_N(scene.scene) <= limit_N
        assert pull_N == pytest.approx(limit_N, rel=0.01)
        assert not lib.scene_robot_holds(scene.scene) and scene.times("object0.dropped") == 0


def test_robots_fixed_grip_slips_at_its_torque_limit():
    """A hand lifts one end of the rod. The torque on the robot's grip is the lifting force times the lever arm. The
    rod's weight adds nothing, because it acts at the grip."""
    at, lever_m, limit_Nm = gripper_at(), 0.12, 0.3
    hand = at + [0, lever_m, 0]
    rod = rod_at(at, held_by_robot=True, robot_grip=lib.GRIP_FIXED)
    with Scene([person_at(hand)], [rod], gripper={"torque_limit_Nm": limit_Nm}) as scene:
        assert scene.grip()
        lift_N = 0.0
        while scene.times("robot.lost") == 0 and scene.now_s < 5:
            scene.aim(0, hand + [0, 0, 0.01 * scene.now_s])
            lift_N = -scene.hand_force()[2]
            scene.step()
        assert lift_N * lever_m == pytest.approx(limit_Nm, rel=0.02)


def test_a_shock_of_one_step_does_not_open_the_jaws():
    """A sudden tug by the hand far exceeds the force limit, but lasts only one or two steps. Only an overload that
    lasts 5 ms opens the jaws."""
    at = gripper_at()
    rod = rod_at(at, held_by_robot=True)
    with Scene([person_at(at)], [rod], gripper={"force_limit_N": 10.0, "stiffness_Npm": 1e5}) as scene:
        scene.set_gravity(0.0)
        scene.step(10)
        assert scene.grip()
        # the hand's aim jumps: the hand of 1.5 kg reaches 0.2 m/s and stops again within two steps
        scene.aim(0, at + [0, 0, 2e-4])
        scene.step(1)
        peak_N = np.linalg.norm(scene.hand_force())
        scene.aim(0, at)
        scene.step(500)
        assert peak_N > 20.0
        assert scene.times("robot.lost") == 0


# ---- objects


def test_a_handed_over_object_is_not_dropped_and_a_released_one_is():
    at = gripper_at()
    rod = rod_at(at, held_by_robot=True, person_grip=lib.GRIP_FIXED)
    with Scene([person_at(at + [0, 0.1, 0])], [rod]) as scene:
        scene.step(100)
        assert scene.grip()
        scene.step(100)
        lib.scene_command_gripper(scene.scene, False)
        scene.step(1)
        assert not lib.scene_robot_holds(scene.scene)  # the robot lets go as soon as the jaws start to open
        scene.step(400)
        assert scene.times("object0.dropped") == 0
        scene.step(2000)  # until the rod hangs still
        let_go_s, height_m = scene.now_s, scene.thing()[0][2]
        lib.scene_open_hand(scene.scene, 0)
        scene.step(100)
        assert scene.first_s("object0.dropped") == pytest.approx(let_go_s + 0.020, abs=2e-3)
        assert scene.times("object0.dropped") == 1 and scene.thing()[0][2] < height_m - 0.03


def test_an_object_never_held_is_not_dropped():
    with Scene([], [rod_at([0.5, 0.5, 0.0])]) as scene:
        scene.step(100)
        assert scene.times("object0.dropped") == 0


@pytest.mark.parametrize("axis", [ALONG_X, ALONG_Y])
@pytest.mark.parametrize("along_m", [0.0, 0.05])
def test_rod_rests_in_its_groove(axis, along_m, ode_messages):
    """A rod whose middle is anywhere above the stand neither creeps, nor sinks in, nor tips."""
    middle = np.array([0.4, 0.2, 0.0])
    thing = rod_on_stand(middle, axis)
    direction = Rotation.from_quat(axis, scalar_first=True).apply(UP)
    reach_m = np.abs(np.array(STAND["size_m"]) @ np.abs(direction)) / 2
    thing[0]["pose"] = (list(middle + min(along_m, 0.8 * reach_m) * direction), axis)
    with Scene([], thing) as scene:
        start, upright = scene.thing()
        scene.step(500)
        settled = scene.thing()[0]
        scene.step(5000)
        rest, rotation = scene.thing()
    assert np.abs(rest - settled).max() < 1e-6  # over 5 s
    assert np.abs(rest - start).max() < 1e-4
    assert (rotation.inv() * upright).magnitude() < 1e-3
    assert ode_messages == []


@pytest.mark.parametrize(("slope_deg", "slides"), [(20, False), (60, True)])
def test_groove_on_a_slope_holds_by_friction(slope_deg, slides):
    """With a friction coefficient of 0.6, the two sides of a V of 90 degrees resist sliding with 0.6 sqrt(2) times the
    force that presses the rod into the V. While the rod settles, they resist less, because friction across the groove
    carries part of the weight. A rod that is held by friction creeps by 1 mm/s per N at each of its four contacts."""
    slope = Rotation.from_euler("x", slope_deg, degrees=True)
    rod, stand = rod_on_stand(HAND_M)
    stand["pose"] = (list(HAND_M - slope.apply(HAND_M - stand["pose"][0])), list(slope.as_quat(scalar_first=True)))
    lying = slope * Rotation.from_quat(ALONG_Y, scalar_first=True)
    rod["pose"] = (list(HAND_M), list(lying.as_quat(scalar_first=True)))
    with Scene([], [rod, stand]) as scene:
        duration_s = 0.15
        scene.step(150)
        way_m = np.linalg.norm(scene.thing()[0] - HAND_M)
    pull, press = np.sin(slope.magnitude()), np.cos(slope.magnitude())
    if slides:
        expected_m = 0.5 * GRAVITY_MPS2 * (pull - 0.6 * 2**0.5 * press) * duration_s**2
        assert way_m == pytest.approx(expected_m, rel=0.15)  # without friction the rod would slide about twice as far
    else:
        assert way_m == pytest.approx(1e-3 * WEIGHT_N * pull / 4 * duration_s, abs=3e-5)


def test_rod_is_lifted_off_its_stand_with_its_weight_alone(ode_messages):
    lift_m, lift_s = 0.05, 1.0
    with Scene([{}], rod_on_stand(HAND_M)) as scene:
        scene.step(200)
        assert scene.grip()
        scene.step(500)
        largest_N = 0.0
        for tick in range(3000):
            s = min(1.0, tick * scene.step_s / lift_s)
            scene.aim(0, HAND_M + lift_m * s**3 * (10 - 15 * s + 6 * s**2) * UP)
            scene.step()
            largest_N = max(largest_N, np.linalg.norm(scene.hand_force()))
        assert scene.hand_force() == pytest.approx(-WEIGHT_N * UP, abs=1e-3)
        assert scene.thing()[0][2] - HAND_M[2] == pytest.approx(lift_m - WEIGHT_N / PERSON["stiffness_Npm"], abs=1e-4)
        assert scene.times("object0.dropped") == 0
        lib.scene_open_hand(scene.scene, 0)
        scene.step(30)
        assert scene.times("object0.dropped") == 1
    push_N = ROD["mass_kg"] * 5.8 * lift_m / lift_s**2  # peak acceleration of a minimum-jerk move
    assert largest_N < WEIGHT_N + push_N + 0.05
    assert ode_messages == []


def test_rod_in_its_groove_taken_by_both(ode_messages):
    """Robot and person grip a rod that lies in its groove, hold it for a while and lift it together."""
    at = gripper_at()
    hand = at + [0.2, 0, 0]
    with Scene([person_at(hand)], rod_on_stand(at + [0.1, 0, 0], ALONG_X, length_m=0.32)) as scene:
        lib.scene_command_gripper(scene.scene, True)
        scene.step(400)
        assert scene.grip() and lib.scene_robot_holds(scene.scene)
        for tick in range(3000):
            scene.aim(0, hand + max(0, tick - 1000) * 1e-5 * UP)
            scene.step()
        assert scene.times("robot.lost") == scene.times("person0.lost") == scene.times("object0.dropped") == 0
    assert ode_messages == []


def test_dropped_rod_ends_flat_on_the_ground(ode_messages):
    tilted = Rotation.from_rotvec([0.9, 0.3, 0]).as_quat(scalar_first=True)
    with Scene([], [rod_at([0.5, 0.5, 0.0], list(tilted))]) as scene:
        scene.step(4000)
        position, rotation = scene.thing()
        scene.step(500)
        assert scene.thing()[0] == pytest.approx(position, abs=1e-4)
        assert position[2] == pytest.approx(-0.4 + ROD["radius_m"], abs=1e-4)
        assert abs(rotation.apply(UP)[2]) < 1e-3
    assert ode_messages == []


def test_points_match_the_geometry():
    turn = Rotation.from_rotvec([0.4, -0.2, 0.3])
    person = {"start": (list(HAND_M), list(turn.as_quat(scalar_first=True))), "grip_m": [0.01, -0.02, 0.06]}
    crank = {"kind": lib.OBJECT_CRANK, "pose": ([0.5, 0.1, 0.1], ALONG_X), "radius_m": 0.04}
    with Scene([person], [rod_at([0.3, 0.1, 0.2]), crank]) as scene:
        for thing in (0, 1):
            scene.scenario.object[thing].point[1].along_m = 0.07
        assert scene.point("POINT_PERSON_GRIP") == pytest.approx(HAND_M + turn.apply([0.01, -0.02, 0.06]), abs=1e-12)
        assert scene.point("POINT_OBJECT", 0, 1) == pytest.approx([0.3, 0.1 + 0.07, 0.2], abs=1e-12)
        # ALONG_X turns z to x and x to -z, so the handle is below the hinge.
        assert scene.point("POINT_OBJECT", 1, 1) == pytest.approx([0.5 + 0.07, 0.1, 0.1 - 0.04], abs=1e-12)


def test_same_commands_same_bits():
    def run() -> bytes:
        at = gripper_at()
        with Scene([person_at(at + [0.2, 0, 0])], rod_on_stand(at + [0.1, 0, 0], ALONG_X)) as scene:
            lib.scene_command_gripper(scene.scene, True)
            scene.step(400)
            scene.grip()
            for tick in range(300):
                scene.aim(0, at + [0.2, 1e-5 * tick, 2e-5 * tick])
                scene.step()
            return scene.thing()[0].tobytes() + scene.hand_force().tobytes()

    assert run() == run()
