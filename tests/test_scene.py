"""The scene's parts against mechanics: the person's compliant hand, grips with their limits, gripper, stand, crank, drops."""

from __future__ import annotations

import hoap3
import numpy as np
import plant_binding
import pytest
from scene_bench import ALONG_X, ALONG_Y, GRAVITY_MPS2, PERSON, START_DEG, Scene
from scipy.spatial.transform import Rotation

ffi, lib = plant_binding.load()
H = 1e-3

ROD_KG = 0.08
FREE_PLACE = np.array([0.4, 0.2, 0.0])  # far from arm, ground and stand
GRIPPER = np.array([0.166, -0.111, 0.014])  # 30 mm before the hand of the manual's check posture
CHECK_DEG = (90, 0, 0, -90)


def rod(at, along=ALONG_Y, **values) -> dict:
    return {"kind": lib.OBJECT_ROD, "pose": (list(at), along), "mass_kg": ROD_KG, **values}


def person(at, **values) -> dict:
    return {"start": (list(at), (1, 0, 0, 0)), **values}


def wxyz(rotation: Rotation) -> list[float]:
    x, y, z, w = rotation.as_quat()
    return [w, x, y, z]


def weight_N(mass_kg: float = ROD_KG) -> float:
    return mass_kg * GRAVITY_MPS2


@pytest.fixture
def solver_messages():
    """What ODE complains about meanwhile."""
    messages = []

    @ffi.callback("void(int, const char *, void *)")
    def hear(number, text, _arguments):
        messages.append((number, ffi.string(text)))

    lib.dSetMessageHandler(hear)
    yield messages
    lib.dSetMessageHandler(ffi.NULL)


# ---- the person's hand


def test_a_free_hand_is_where_it_is_aimed():
    """Also at 3 m/s and 10 rad/s."""
    with Scene([person(FREE_PLACE)]) as scene:
        for n in range(1, 1001):
            t = n * H
            position = FREE_PLACE + [0.2 * np.sin(15 * t), 0.1 * t, 0.05 * np.sin(40 * t)]
            turn = Rotation.from_rotvec([1.0 * np.sin(10 * t), 0.3 * t, -0.5 * np.sin(3 * t)])
            scene.aim(0, position, wxyz(turn))
            scene.step()
            at, rotation = scene.hand()
            assert np.abs(at - position).max() < 1e-9
            assert (rotation * turn.inv()).magnitude() < 1e-7  # acos of a float near 1
    assert np.abs(position - FREE_PLACE).max() > 0.05


class Hand:
    """A hand alone in a world, pushed by the test."""

    def __init__(self, **values):
        data = ffi.new("person_t *")
        for name, value in {**PERSON, **person(FREE_PLACE), **values}.items():
            setattr(data, name, value)
        self.world, self.body = lib.physics_create(), ffi.new("hand_body_t *")
        lib.hand_body_init(self.body, self.world, data)

    def __enter__(self) -> Hand:
        return self

    def __exit__(self, *_) -> None:
        lib.physics_destroy(self.world)

    def step(self, force_N=(0, 0, 0), torque_Nm=(0, 0, 0)) -> None:
        lib.hand_body_push(self.body, H)
        lib.dBodyAddForce(self.body.body, *force_N)
        lib.dBodyAddTorque(self.body.body, *torque_Nm)
        lib.physics_step(self.world, H)

    def off(self) -> tuple[np.ndarray, np.ndarray]:
        """Displacement from the aim, m, and rotation vector from it, rad."""
        pose = ffi.new("rigid_pose_t *")
        lib.hand_body_pose(self.body, pose)
        w, x, y, z = pose.rotation
        return np.array(list(pose.position_m)) - FREE_PLACE, Rotation.from_quat([x, y, z, w]).as_rotvec()


def test_a_steady_pull_meets_the_arms_stiffness():
    force, torque = np.array([4.0, -3.0, 6.0]), np.array([0.3, 0.2, -0.1])
    with Hand(stiffness_Npm=250.0, stiffness_Nmprad=2.5, damping_ratio=1.0) as hand:
        for _ in range(2000):
            hand.step(force, torque)
        way, turn = hand.off()
    assert np.allclose(way, force / 250.0, atol=1e-8)
    assert np.allclose(turn, torque / 2.5, atol=1e-6)


@pytest.mark.parametrize("ratio", [0.2, 0.4, 0.7])
def test_a_hand_let_go_swings_with_its_damping_ratio(ratio):
    """The overshoot of a second-order system is exp(-pi ratio / sqrt(1 - ratio^2)), of arm and wrist alike."""
    with Hand(damping_ratio=ratio) as hand:
        for _ in range(3000):
            hand.step([10.0, 0, 0], [0, 0.3, 0])
        (start, turned), ways, turns = hand.off(), [], []
        for _ in range(1000):
            hand.step()
            way, turn = hand.off()
            ways.append(way[0])
            turns.append(turn[1])
    expected = np.exp(-np.pi * ratio / np.sqrt(1 - ratio**2))
    assert -min(ways) / start[0] == pytest.approx(expected, rel=0.03)
    assert -min(turns) / turned[1] == pytest.approx(expected, rel=0.06)


# ---- a person's grip


@pytest.mark.parametrize("kind", ["GRIP_BALL", "GRIP_FIXED"])
def test_what_is_held_shows_its_weight_at_the_hand(kind):
    with Scene([person(FREE_PLACE)], [rod(FREE_PLACE, person_grip=getattr(lib, kind))]) as scene:
        assert np.array_equal(scene.hand_force(), np.zeros(3))
        assert scene.grip()
        scene.step(3000)
        assert np.allclose(scene.hand_force(), [0, 0, -weight_N()], atol=1e-4)
        assert scene.hand()[0][2] == pytest.approx(-weight_N() / 300.0, abs=1e-6)
        assert scene.times("person0.holds") == 1 and lib.scene_holds(scene.scene, 0, 0)


def test_two_holders_share_the_weight_as_a_lever_does():
    """At 60 and 120 mm from the rod's middle: two thirds and one third."""
    places = [FREE_PLACE - [0, 0.06, 0], FREE_PLACE + [0, 0.12, 0]]
    with Scene([person(place, damping_ratio=1.0) for place in places], [rod(FREE_PLACE)]) as scene:
        assert scene.grip(0) and scene.grip(1)
        scene.step(3000)
        assert scene.hand_force(0)[2] == pytest.approx(-weight_N() * 2 / 3, rel=1e-3)
        assert scene.hand_force(1)[2] == pytest.approx(-weight_N() / 3, rel=1e-3)


def test_a_fixed_grip_turns_what_it_holds_and_a_ball_does_not():
    for kind, share in (("GRIP_FIXED", 1.0), ("GRIP_BALL", 0.0)):
        with Scene([person(FREE_PLACE, stiffness_Nmprad=50.0)], [rod(FREE_PLACE, person_grip=getattr(lib, kind))]) as scene:
            scene.set_gravity(0.0)
            scene.grip()
            before = scene.thing()[1]
            for n in range(1000):
                turn = Rotation.from_rotvec([0.5 * (1 - np.cos(np.pi * n / 999)) * 0.6, 0, 0])
                scene.aim(0, FREE_PLACE, wxyz(turn))
                scene.step()
            scene.step(500)
            turned = (scene.thing()[1] * before.inv()).as_rotvec()
            assert np.allclose(turned, [0.6 * share, 0, 0], atol=0.005)


def test_a_grip_snaps_nothing_together():
    """Gripped 10 mm beside its axis, the rod stays where it is, and the hand feels its weight only."""
    with Scene([person(FREE_PLACE + [0.01, 0, 0], damping_ratio=1.0)], [rod(FREE_PLACE)]) as scene:
        scene.set_gravity(0.0)
        assert scene.grip()
        for _ in range(200):
            scene.step()
            assert np.linalg.norm(scene.hand_force()) < 1e-9
        assert np.abs(scene.thing()[0] - FREE_PLACE).max() < 1e-12


@pytest.mark.parametrize(("off_m", "within"), [([0.0149, 0, 0], True), ([0.0151, 0, 0], False), ([0, 0.164, 0], True),
                                               ([0, 0.166, 0], False)])  # fmt: skip
def test_fingers_reach_15_mm_around_the_rod_and_beyond_its_end(off_m, within):
    with Scene([person(FREE_PLACE + off_m)], [rod(FREE_PLACE, length_m=0.3)]) as scene:
        assert scene.grip() == within
        assert lib.scene_holds(scene.scene, 0, 0) == within
        assert scene.times("person0.holds") == int(within)


def test_a_hand_holds_one_thing_and_no_stand():
    stand = {"kind": lib.OBJECT_STAND, "pose": (list(FREE_PLACE), (1, 0, 0, 0))}
    with Scene([person(FREE_PLACE)], [rod(FREE_PLACE), rod(FREE_PLACE), stand]) as scene:
        assert not scene.grip(0, 2)
        assert scene.grip(0, 1) and not scene.grip(0, 0)


def pull_apart(scene: Scene, puller: int, from_m, speed_mps, until: str, patience_s: float) -> np.ndarray:
    """The puller's hand goes along +y until the event; the force at it before each step, (N, 3)."""
    forces = []
    for n in range(1, round(patience_s / H)):
        forces.append(scene.hand_force(puller))
        scene.aim(puller, np.array(from_m) + [0, speed_mps * n * H, 0])
        scene.step()
        if scene.times(until):
            return np.array(forces)
    pytest.fail(f"no {until} within {patience_s} s")


def test_a_persons_grip_gives_way_at_its_limit():
    places = [FREE_PLACE - [0, 0.1, 0], FREE_PLACE + [0, 0.1, 0]]
    people = [person(places[0], grip_force_limit_N=10.0, damping_ratio=1.0), person(places[1], damping_ratio=1.0)]
    with Scene(people, [rod(FREE_PLACE)]) as scene:
        scene.set_gravity(0.0)
        scene.grip(0), scene.grip(1)
        # Two springs of 300 N/m in series: 10 N are reached as the puller has gone 67 mm.
        forces = pull_apart(scene, 1, places[1], 0.05, "person0.lost", 2.0)
        assert np.abs(forces[-1]) == pytest.approx([0, 10.0, 0], abs=0.15)
        assert scene.now_s == pytest.approx(10.0 / 150.0 / 0.05, abs=0.05)
        assert scene.times("person1.lost") == 0 and scene.times("object0.dropped") == 0
        assert not lib.scene_holds(scene.scene, 0, 0) and lib.scene_holds(scene.scene, 1, 0)


@pytest.mark.parametrize(("shock_steps", "lost"), [(1, 0), (40, 1)])
def test_one_steps_shock_opens_no_hand(shock_steps, lost):
    """Three times the limit (no stiffness: the puller's acceleration alone gives the force) for 1 ms, or for 40 ms."""
    places = [FREE_PLACE - [0, 0.1, 0], FREE_PLACE + [0, 0.1, 0]]
    limp = {"stiffness_Npm": 0.0, "mass_kg": 1.5}
    people = [person(places[0], grip_force_limit_N=10.0, **limp), person(places[1], **limp)]
    with Scene(people, [rod(FREE_PLACE, mass_kg=0.001)]) as scene:
        scene.set_gravity(0.0)
        scene.grip(0), scene.grip(1)
        aim, speed, peak_N = places[1].copy(), 0.0, 0.0
        for n in range(100):
            speed += 40.0 * H if n < shock_steps else 0.0  # 60 N on two hands of the same mass: 30 N at the other
            aim = aim + [0, speed * H, 0]
            scene.aim(1, aim)
            scene.step()
            peak_N = max(peak_N, np.linalg.norm(scene.hand_force(0)))
        assert peak_N == pytest.approx(30.0, rel=0.01)
        assert scene.times("person0.lost") == lost


# ---- the robot's gripper


def closed_on(scene: Scene) -> None:
    lib.scene_command_gripper(scene.scene, True)
    scene.step(400)
    assert lib.scene_robot_holds(scene.scene)


def test_jaws_take_their_stroke():
    with Scene(gripper={"stroke_s": 0.2}) as scene:
        assert lib.scene_gripper_opening(scene.scene) == 1.0
        lib.scene_command_gripper(scene.scene, True)
        scene.step(100)
        assert lib.scene_gripper_opening(scene.scene) == pytest.approx(0.5, abs=1e-9)
        scene.step(150)
        assert lib.scene_gripper_opening(scene.scene) == 0.0
        assert scene.times("robot.closed") == 1 and scene.first_s("robot.closed") == pytest.approx(0.2, abs=2 * H)
        lib.scene_command_gripper(scene.scene, False)
        scene.step(250)
        assert lib.scene_gripper_opening(scene.scene) == 1.0
        assert scene.times("robot.opened") == 1 and scene.first_s("robot.opened") == pytest.approx(0.45, abs=2 * H)
        assert scene.times("robot.holds") == 0 and not lib.scene_robot_holds(scene.scene)


@pytest.mark.parametrize(("off_m", "within"), [(0.0145, True), (0.0155, False)])
def test_jaws_grip_what_is_between_them(off_m, within):
    with Scene([], [rod(GRIPPER + [off_m, 0, 0])], start_deg=CHECK_DEG) as scene:
        scene.set_gravity(0.0)
        lib.scene_command_gripper(scene.scene, True)
        scene.step(400)
        assert lib.scene_robot_holds(scene.scene) == within == lib.scene_holds(scene.scene, lib.SCENE_HOLDER_ROBOT, 0)
        assert (scene.times("robot.holds"), scene.times("robot.closed")) == ((1, 0) if within else (0, 1))
        assert (lib.scene_gripper_opening(scene.scene) > 0.0) == within
        lib.scene_command_gripper(scene.scene, False)
        scene.step()
        assert not lib.scene_robot_holds(scene.scene) and scene.times("robot.opened") == 0


def test_held_from_the_start():
    with Scene([], [rod(GRIPPER, held_by_robot=True)], start_deg=CHECK_DEG) as scene:
        assert lib.scene_robot_holds(scene.scene)
        scene.step(1000)
        assert lib.scene_robot_holds(scene.scene)
        assert scene.times("object0.dropped") == 0 == scene.times("robot.closed")


@pytest.mark.parametrize("kind", ["GRIP_BALL", "GRIP_FIXED"])
def test_pads_give_way_as_springs(kind):
    """Held in its middle, a rod of 0.3 kg sinks by its weight over the stiffness."""
    thing = rod(GRIPPER, held_by_robot=True, mass_kg=0.3, robot_grip=getattr(lib, kind))
    with Scene([], [thing], start_deg=CHECK_DEG, gripper={"stiffness_Npm": 1500.0}) as scene:
        scene.step(2000)
        sunk = scene.point("POINT_ROBOT_GRIPPER") - scene.thing()[0]
        assert np.allclose(sunk, [0, 0, weight_N(0.3) / 1500.0], atol=2e-6)
        assert lib.scene_gripper_force_N(scene.scene) == pytest.approx(weight_N(0.3), rel=1e-4)


@pytest.mark.parametrize("kind", ["GRIP_BALL", "GRIP_FIXED"])
def test_the_arms_joints_bear_what_the_gripper_holds(kind):
    """Torque = the arm's own + J' times the rod's weight, J from numpy's kinematics."""
    q, mass = np.radians([80, -30, 15, -70]), 0.25
    hand = hoap3.frames(q)[4]
    gripper = hand[:3, :3] @ [0, 0, 0.03] + hand[:3, 3]
    thing = rod(gripper, held_by_robot=True, mass_kg=mass, robot_grip=getattr(lib, kind))
    with Scene([], [thing], start_deg=np.degrees(q).tolist()) as scene:
        scene.step(2000)
        measured = [lib.arm_plant_torque_Nm(scene.arm, i) for i in range(4)]

    def height(q):
        frame = hoap3.frames(q)[4]
        return (frame[:3, :3] @ [0, 0, 0.03] + frame[:3, 3])[2]

    slope = np.array([(height(q + 1e-6 * e) - height(q - 1e-6 * e)) / 2e-6 for e in np.eye(4)])
    assert np.abs(slope).max() > 0.05
    assert np.allclose(measured, hoap3.holding_torque(q) + weight_N(mass) * slope, atol=1e-3)


def test_the_gripper_slips_at_its_force_limit_and_not_before():
    """A person pulls with a force that grows by 5 N/s; it is measured at the person's own hand."""
    start = GRIPPER + [0, 0.12, 0]
    things = [rod(GRIPPER, held_by_robot=True, mass_kg=0.01)]
    puller = person(start, stiffness_Npm=500.0, damping_ratio=1.0)
    with Scene([puller], things, start_deg=CHECK_DEG, gripper={"force_limit_N": 8.0}) as scene:
        scene.set_gravity(0.0)
        scene.grip()
        forces = np.linalg.norm(pull_apart(scene, 0, start, 0.01, "robot.lost", 4.0), axis=1)
        assert forces[-1] == pytest.approx(8.0, abs=0.2) and forces.max() < 8.2
        assert not lib.scene_robot_holds(scene.scene) and lib.scene_holds(scene.scene, 0, 0)
        assert lib.scene_gripper_force_N(scene.scene) == 0.0 and scene.times("object0.dropped") == 0


@pytest.mark.parametrize(("limit_share", "lost"), [(0.97, 1), (1.03, 0)])
def test_a_fixed_grip_slips_at_its_torque_limit(limit_share, lost):
    """A rod gripped 60 mm from its middle pulls with its weight times 60 mm at the jaws."""
    mass, lever = 0.4, 0.06
    limit = limit_share * weight_N(mass) * lever
    thing = rod(GRIPPER + [0, lever, 0], held_by_robot=True, mass_kg=mass, robot_grip=lib.GRIP_FIXED)
    gripper = {"torque_limit_Nm": limit, "stiffness_Npm": 1e5, "damping_Nspm": 1e3}
    with Scene([], [thing], start_deg=CHECK_DEG, gripper=gripper) as scene:
        for n in range(1, 1001):  # the weight grows: no swing
            scene.set_gravity(-GRAVITY_MPS2 * n / 1000)
            scene.step()
        scene.step(300)
        assert scene.times("robot.lost") == lost == 1 - int(lib.scene_robot_holds(scene.scene))


# ---- drops, handing over


def test_let_go_it_drops_and_falls():
    with Scene([person(FREE_PLACE)], [rod(FREE_PLACE)]) as scene:
        scene.step(100)  # falls from the start, but nobody has ever held it
        assert scene.times("object0.dropped") == 0
    with Scene([person(FREE_PLACE, stiffness_Npm=1e4)], [rod(FREE_PLACE)]) as scene:
        scene.grip()
        scene.step(1000)
        height, released = scene.thing()[0][2], scene.now_s
        lib.scene_open_hand(scene.scene, 0)
        scene.step(200)
        fallen = 0.5 * GRAVITY_MPS2 * 0.2 * (0.2 + H)
        assert height - scene.thing()[0][2] == pytest.approx(fallen, abs=1e-4)
        assert scene.times("object0.dropped") == 1
        assert scene.first_s("object0.dropped") - released == pytest.approx(0.020, abs=2 * H)
        assert scene.times("person0.lost") == 0  # let go is not lost


def test_handing_over_is_no_drop():
    places = [FREE_PLACE - [0, 0.1, 0], FREE_PLACE + [0, 0.1, 0]]
    with Scene([person(place) for place in places], [rod(FREE_PLACE)]) as scene:
        scene.grip(0)
        scene.step(200)
        assert scene.grip(1) or pytest.fail("the rod has swung out of the second hand's reach")
        scene.step(50)
        lib.scene_open_hand(scene.scene, 0)
        scene.step(200)
        assert lib.scene_holds(scene.scene, 1, 0) and scene.times("object0.dropped") == 0


def test_a_dropped_rod_comes_to_rest_on_the_ground(solver_messages):
    with Scene([], [rod([0.4, 0.2, -0.3])]) as scene:
        scene.step(1500)
        before = scene.thing()[0]
        scene.step(1000)
        assert before[2] == pytest.approx(-0.4 + 0.008, abs=2e-4)
        assert np.abs(scene.thing()[0] - before).max() < 1e-4
    assert solver_messages == []


# ---- the stand

STAND_AT = np.array([0.4, 0.2, -0.05])


def on_stand(**values) -> list[dict]:
    stand = {"kind": lib.OBJECT_STAND, "pose": (list(STAND_AT), (1, 0, 0, 0)), "size_m": [0.06, 0.12, 0.04]}
    return [rod(STAND_AT + [0, 0.02, 0.028], **values), stand]


def test_a_rod_rests_on_its_stand(solver_messages):
    with Scene([], on_stand()) as scene:
        scene.step(500)
        before, turn = scene.thing()
        scene.step(3000)
        after, turned = scene.thing()
        assert np.abs(after - before).max() < 3e-4  # 0.1 mm/s
        assert (turned * turn.inv()).magnitude() < 1e-3
        assert np.abs(after - STAND_AT - [0, 0.02, 0.028]).max() < 5e-4
    assert solver_messages == []


def test_a_rod_lifts_off_freely(solver_messages):
    """Gripped on the stand, raised by 50 mm: the hand bears the weight and nothing else."""
    things = on_stand()
    start = STAND_AT + [0, 0.02, 0.028]
    with Scene([person(start, damping_ratio=1.0)], things) as scene:
        scene.step(300)
        assert scene.grip()
        lifts = []
        for n in range(1, 1001):
            scene.aim(0, start + [0, 0, 0.025 * (1 - np.cos(np.pi * n / 1000))])
            scene.step()
            lifts.append(scene.hand_force()[2])
        scene.step(1500)
        assert np.allclose(scene.hand_force(), [0, 0, -weight_N()], atol=1e-3)
        assert min(lifts) > -1.2 * weight_N()  # 0.25 m/s^2 is 2.5 % more than the weight, and the arm swings a little
    assert solver_messages == []


# ---- the crank

HINGE = np.array([0.5, 0.2, 0.0])


def crank(**values) -> dict:
    return {"kind": lib.OBJECT_CRANK, "pose": (list(HINGE), ALONG_Y), "radius_m": 0.05, "mass_kg": 0.1, **values}


def turn_crank(scene: Scene, turns: float, seconds: float) -> dict[str, float]:
    """From rest to rest: work done on the crank through the hand's joint, and what damping and friction took, J."""
    body = {"work": 0.0, "path": 0.0, "rate2": 0.0}
    _, frame = scene.thing()
    angle, handle = 0.0, scene.point("POINT_OBJECT")
    for n in range(1, round(seconds / H) + 1):
        s = n * H / seconds
        aim = 2 * np.pi * turns * (10 * s**3 - 15 * s**4 + 6 * s**5)
        scene.aim(0, HINGE + frame.apply([0.05 * np.cos(aim), 0.05 * np.sin(aim), 0]))
        scene.step()
        now = scene.point("POINT_OBJECT")
        body["work"] += -scene.hand_force() @ (now - handle)
        seen = frame.inv().apply(now - HINGE)
        step = np.remainder(np.arctan2(seen[1], seen[0]) - angle + np.pi, 2 * np.pi) - np.pi
        angle += step
        body["path"] += abs(step)
        body["rate2"] += step**2 / H
        handle = now
    return {**body, "angle": angle}


@pytest.mark.parametrize("turns", [3.0, -2.0])
def test_the_cranks_work_goes_into_friction_and_nowhere_else(turns):
    """From rest to rest over whole turns; and the turns are counted with their sign."""
    friction, damping = 0.03, 0.01
    thing = crank(friction_Nm=friction, damping_Nmspprad=damping, point_count=1)
    holder = person(HINGE + Rotation.from_rotvec([-np.pi / 2, 0, 0]).apply([0.05, 0, 0]), stiffness_Npm=2000.0, damping_ratio=1.0)
    with Scene([holder], [thing]) as scene:
        assert scene.grip()
        scene.step(500)
        done = turn_crank(scene, turns, 4.0)
        expected = friction * done["path"] + damping * done["rate2"]
        assert done["path"] == pytest.approx(abs(turns) * 2 * np.pi, abs=0.1)
        assert done["work"] == pytest.approx(expected, rel=0.01)
        assert lib.scene_crank_turns(scene.scene, 0) == pytest.approx(turns, abs=0.02)
        assert scene.times("person0.lost") == 0


@pytest.mark.parametrize(("share", "moves"), [(0.95, True), (1.05, False)])
def test_dry_friction_holds_the_handle_up(share, moves):
    """The handle starts at the side: its weight turns with m g r."""
    with Scene([], [crank(friction_Nm=share * weight_N(0.1) * 0.05)]) as scene:
        scene.step(500)
        assert (abs(lib.scene_crank_turns(scene.scene, 0)) > 0.01) == moves


def test_a_free_crank_is_a_pendulum():
    """Handle of 0.1 kg on 50 mm, about the hinge: thin disk's 10 mm radius for its own inertia. Half a swing from the side
    takes what numpy integrates."""
    with Scene([], [crank(damping_Nmspprad=0.0, friction_Nm=0.0)], step_s=0.5e-3) as scene:
        inertia = 0.1 * (0.5 * 0.01**2 + 0.05**2)
        q, rate, t = 0.0, 0.0, 0.0
        while rate >= 0.0:  # midpoint rule, q from the side downwards
            half = rate + 0.5e-5 * weight_N(0.1) * 0.05 * np.cos(q) / inertia
            q += 1e-5 * half
            rate += 1e-5 * weight_N(0.1) * 0.05 * np.cos(q - 0.5e-5 * half) / inertia
            t += 1e-5
        turns = []
        for _ in range(round(1.2 * t / 0.5e-3)):
            scene.step()
            turns.append(abs(lib.scene_crank_turns(scene.scene, 0)))
        assert max(turns) == pytest.approx(0.5, abs=0.002)
        assert np.argmax(turns) * 0.5e-3 == pytest.approx(t, abs=1.5e-3)


# ---- points


def test_points_are_where_the_things_are():
    place, turn = np.array([0.3, 0.3, 0.1]), Rotation.from_rotvec([0.3, -0.7, 1.1])
    things = [{**rod(place, wxyz(turn)), "point_count": 2}, crank(point_count=2)]
    people = [{**PERSON, "start": (list(place), wxyz(turn)), "grip_m": [0.01, 0.02, 0.09]}]
    with Scene(people, things) as scene:
        for thing in range(2):
            scene.scenario.object[thing].point[1].along_m = 0.07
        assert np.allclose(scene.point("POINT_OBJECT", 0, 1), place + turn.apply([0, 0, 0.07]), atol=1e-12)
        handle = HINGE + Rotation.from_rotvec([-np.pi / 2, 0, 0]).apply([0.05, 0, 0.07])
        assert np.allclose(scene.point("POINT_OBJECT", 1, 1), handle, atol=1e-12)
        assert np.allclose(scene.point("POINT_PERSON_GRIP", 0), place + turn.apply([0.01, 0.02, 0.09]), atol=1e-12)
        hand = hoap3.frames(np.radians(START_DEG))[4]
        gripper = hand[:3, :3] @ [0, 0, 0.03] + hand[:3, 3]
        assert np.allclose(scene.point("POINT_ROBOT_GRIPPER"), gripper, atol=1e-9)


def test_same_commands_same_bits():
    def run() -> bytes:
        start = GRIPPER + [0, 0.1, 0]
        with Scene([person(start)], [rod(GRIPPER), *on_stand()], start_deg=CHECK_DEG) as scene:
            scene.set_gravity(0.0)
            closed_on(scene)
            scene.set_gravity(-GRAVITY_MPS2)
            scene.grip()
            trace = []
            for n in range(500):
                lib.arm_plant_set_velocity(scene.arm, 0, 0.3 * np.sin(0.02 * n))
                scene.step()
                trace += [scene.hand()[0], scene.hand_force(), *(scene.thing(i)[0] for i in range(2))]
            return np.array(trace).tobytes()

    assert run() == run()
