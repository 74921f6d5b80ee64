"""The smallest clearances in a scene agree with geometry, and proximity sensor and gripper send the right bus
messages."""

from __future__ import annotations

import itertools

import controller_bench
import hoap3
import numpy as np
import proximity_binding
import pytest
from comanip._core import ffi as core_ffi
from comanip._core import lib as core
from e2e import p05
from scipy.spatial.transform import Rotation

ffi, lib = proximity_binding.load()

ERROR_M = 0.00005  # the same as CONVEX_DISTANCE_ERROR_M
MS = 1_000_000
POSTURE_DEG = (90, 0, 0, -90)  # upper arm down, forearm forward along x; end effector at (0.136, -0.111, 0.014)
HAND = np.array([0.136, -0.111, 0.014])
ROBOT = 2  # index of the robot among the holders
WRIST_M = 0.06  # from the hand's origin back to the wrist
# a hand that points back at the robot; its x axis, the direction of its thickness, points along the world's z axis
FACING = Rotation.from_euler("y", -90, degrees=True)


class Scene:
    """A scenario and a scene that matches it, with the arm at POSTURE_DEG and people's hands far away."""

    def __init__(self, people: int = 1):
        self.scenario = ffi.new("scenario_t *", {"person_count": people})
        self.scenario.gripper.offset_m = [0, 0, 0.03]
        self.arm = ffi.new("struct arm_plant *")
        self.scene = ffi.new("struct scene *", {"arm": self.arm})
        self.set_posture(POSTURE_DEG)
        self.set_pose(self.scene.robot_cup, (0, 0, 0))
        for i in range(people):
            person = self.scenario.person[i]
            person.name = [b"person", b"taker"][i]
            person.elbow_m = [5.3, 0, 0]
            self.set_pose(person.start, (5, 0, 0), FACING)
            self.set_hand((5, 0, 0), FACING, person=i)

    @staticmethod
    def set_pose(pose, position_m, rotation=None) -> None:
        x, y, z, w = (rotation or Rotation.identity()).as_quat()
        pose.rotation = [w, x, y, z]
        pose.position_m = list(map(float, position_m))

    def set_posture(self, degrees) -> None:
        self.arm.position_rad = list(np.radians(degrees))

    def set_hand(self, position_m, rotation=FACING, person: int = 0) -> None:
        self.set_pose(self.scene.hand[person], position_m, rotation)

    def set_elbow(self, position_m, wrist_to_elbow_m: float = 0.3) -> None:
        """Sets the first person's elbow and the forearm length at the start."""
        self.scenario.person[0].elbow_m = list(map(float, position_m))
        self.set_pose(self.scenario.person[0].start, np.asarray(position_m) - [0, 0, wrist_to_elbow_m - WRIST_M])

    def add_rod(self, position_m, rotation=None, length_m=0.2, radius_m=0.01) -> int:
        i = self.scenario.object_count
        self.scenario.object_count += 1
        rod = self.scenario.object[i]
        rod.kind, rod.length_m, rod.radius_m = lib.OBJECT_ROD, length_m, radius_m
        self.set_pose(self.scene.object[i], position_m, rotation)
        return i

    def add_grip(self, person: int, rod: int) -> None:
        who = self.scenario.person[person]
        who.step[who.step_count].action, who.step[who.step_count].object = lib.PERSON_GRIP, rod
        who.step_count += 1

    def hold(self, holder: int, rod: int, holds: bool = True) -> None:
        self.scene.holds[holder][rod] = holds

    def proximity(self):
        return ffi.gc(lib.proximity_create(self.scenario, self.scene), lib.proximity_destroy)

    def measure(self, proximity=None) -> tuple[float, str, float, str]:
        """Returns the clearance and the name of the closest pair of parts, first between person and robot, then between
        parts of the robot."""
        proximity = proximity or self.proximity()
        found = lib.proximity_measure(proximity)
        names = [
            ffi.string(lib.proximity_pair_name(proximity, pair)).decode()
            for pair in (found.person_pair, found.self_pair)
        ]
        return found.person_m, names[0], found.self_m, names[1]


FROM_THE_RIGHT = Rotation.from_matrix([[0, -1, 0], [0, 0, 1], [-1, 0, 0]])  # points to the left and lies flat

# ---- clearance to people


@pytest.mark.parametrize("height_m", [0.0, 0.0004, 0.003, 0.01])
def test_flat_hand_above_the_forearm(height_m):
    """The forearm is a rod of 20 mm radius, and the open hand is 30 mm thick. The hand points to the right, with its
    elbow above."""
    scene = Scene()
    hand_m = np.array([0.08, -0.111, HAND[2] + 0.020 + 0.015 + height_m])
    to_the_right = Rotation.from_matrix([[0, 1, 0], [0, 0, -1], [-1, 0, 0]])  # x down, y forward, z to the right
    scene.set_hand(hand_m, to_the_right)
    scene.set_elbow(hand_m + [0, 0.1, 0.3])
    clearance_m, pair, *_ = scene.measure()
    assert clearance_m == pytest.approx(height_m, abs=ERROR_M)
    assert pair == "person.hand - robot.forearm"


@pytest.mark.parametrize(
    ("hand_m", "rotation", "clearance_m", "part"),
    [
        # The finger tips, 0.12 m in front of the hand's origin, point at the gripper. Its box extends 55 mm in front of
        # the end effector.
        (HAND + [0.055 + 0.12 + 0.03, 0, 0], FACING, 0.03, "gripper"),
        # from the left towards the torso, which is 150 mm wide
        ([-0.035, 0.075 + 0.12 + 0.05, 0.1], Rotation.from_euler("x", 90, degrees=True), 0.05, "torso"),
        # from above towards the head, which ends at 0.32 m
        ([-0.03, 0, 0.32 + 0.12 + 0.08], Rotation.from_euler("x", 180, degrees=True), 0.08, "head"),
        # from the right towards the upper arm, 75 mm below the shoulder, and towards the shoulder, a cube of 50 mm
        ([-0.035, -0.111 - 0.02 - 0.12 - 0.04, 0.125 - 0.075], FROM_THE_RIGHT, 0.04, "upper_arm"),
        ([-0.035, -0.111 - 0.025 - 0.12 - 0.04, 0.125], FROM_THE_RIGHT, 0.04, "shoulder"),
    ],
)  # fmt: skip
def test_finger_tips_in_front_of_each_part(hand_m, rotation, clearance_m, part):
    scene = Scene()
    scene.set_hand(hand_m, rotation)
    scene.set_elbow(hand_m - rotation.apply([0, 0, 0.36]))
    found_m, pair, *_ = scene.measure()
    assert found_m == pytest.approx(clearance_m, abs=ERROR_M)
    assert pair == f"person.hand - robot.{part}"


@pytest.mark.parametrize("degrees", [(90, -5, 0, -90), (60, -40, 20, -70), (20, -80, -50, -20), (-60, -10, 80, -110)])
def test_arm_parts_follow_the_kinematics(degrees):
    """A person's hand holds a crumb, 2 mm wide and long, beside the middle of each link in turn. The clearance to the
    link is correct in each posture of the arm."""
    scene = Scene()
    scene.set_posture(degrees)
    link = hoap3.frames(np.radians(degrees))
    shoulder, elbow, hand = link[0][:3, 3], link[2][:3, 3], link[4][:3, 3]
    rod = scene.add_rod((0, 0, 0), length_m=0.002, radius_m=0.001)
    scene.hold(0, rod)
    proximity = scene.proximity()
    for start, end, part in ((shoulder, elbow, "upper_arm"), (elbow, hand, "forearm")):
        along = (end - start) / np.linalg.norm(end - start)
        middle = 0.45 * start + 0.55 * end
        for side in Rotation.from_rotvec(np.outer(np.arange(8) * np.pi / 4, along)):
            away = side.apply(np.linalg.svd(along[None])[2][1])
            at = middle + 0.03 * away
            if at[0] < 0.03 and at[1] > -0.09:
                continue  # the torso is closer
            # turns the end face of the crumb (a rod of 1 mm radius) towards the link
            across = Rotation.align_vectors([away], [[0, 0, 1]])[0]
            scene.set_pose(scene.scene.object[rod], at, across)
            found_m, pair, *_ = scene.measure(proximity)
            assert found_m == pytest.approx(0.03 - 0.001 - 0.020, abs=ERROR_M)
            assert pair == f"person.held - robot.{part}"


def test_forearm_points_from_wrist_to_elbow():
    """The elbow stays 50 mm in front of the gripper's face wherever the hand is. The part of the forearm that is
    closest to the gripper is therefore the forearm's end, 45 mm in radius, or its side."""
    scene = Scene()
    elbow_m = np.array([HAND[0] + 0.055 + 0.05, *HAND[1:]])
    scene.set_elbow(elbow_m)
    proximity = scene.proximity()
    for way, radius_m in (([1, 0, 0], 0), ([0, 0.1, 1], 0.045), ([0, -1, 0.1], 0.045), ([0, -0.1, -1], 0.045)):
        away = np.array(way) / np.linalg.norm(way)
        scene.set_hand(elbow_m + 0.36 * away, Rotation.align_vectors([away], [[0, 0, 1]])[0])
        found_m, pair, *_ = scene.measure(proximity)
        assert pair == "person.forearm - robot.gripper"
        # The rounded shape is modelled as a hull with eight corners.
        assert 0.05 - radius_m - 0.001 < found_m < 0.05 - radius_m * np.cos(np.pi / 8) + 0.001


def test_cups_count_as_solid():
    scene = Scene()
    for cup in (scene.scenario.cup, scene.scenario.person[0].cup):
        cup.present, cup.radius_m, cup.height_m, cup.wall_m = True, 0.03, 0.08, 0.002
    scene.scenario.person[0].cup.mount.rotation = [1, 0, 0, 0]
    scene.scenario.person[0].cup.mount.position_m = [
        0,
        0,
        2,
    ]  # 2 m in front of the hand, so that no other part of the person is close
    at = np.array([0.3, -0.6, 0.3])
    scene.set_pose(scene.scene.robot_cup, at)
    # The cups are first side by side, with their outer surfaces 10 mm apart, and then one above the other. A cup's
    # bottom is 2 mm below its frame, and its rim 80 mm above it.
    for offset, clearance_m in (([0.064 + 0.01, 0, 0], 0.01), ([0, 0, 0.08 + 0.002 + 0.005], 0.005)):
        scene.set_hand(at + offset - [0, 0, 2], Rotation.identity())
        found_m, pair, *_ = scene.measure()
        assert found_m == pytest.approx(clearance_m, abs=ERROR_M)
        assert pair == "person.cup - robot.cup"


def test_nothing_close():
    scene = Scene()
    found = lib.proximity_measure(scene.proximity())
    assert (found.person_m, found.person_pair) == (1.0, -1)
    assert found.self_pair >= 0
    nobody = Scene(people=0)
    assert nobody.measure()[:2] == (1.0, "")


# ---- intended contact


def test_a_rod_that_the_person_will_take_may_touch_hand_and_forearm():
    for takes in (False, True):
        scene = Scene(people=2)
        rod = scene.add_rod(HAND + [0.03 + 0.06, 0, 0], Rotation.from_euler("y", 90, degrees=True))
        scene.hold(ROBOT, rod)
        if takes:
            scene.add_grip(0, rod)
        scene.set_hand(HAND + [0.22, 0, 0])  # with the finger tips over the rod
        found_m, pair, *_ = scene.measure()
        # curled fingers end 45 mm in front of the palm; the closest part of the robot is then the gripper's face, 55 mm
        # in front of the end effector
        if takes:
            assert (found_m, pair) == (pytest.approx(0.22 - 0.045 - 0.055, abs=ERROR_M), "person.hand - robot.gripper")
        else:
            assert (found_m, pair) == (0.0, "person.hand - robot.held")
        scene.set_hand(HAND + [0.22, 0, 0], person=1)  # the other person may never touch the rod
        assert scene.measure()[0] == 0.0 and scene.measure()[1].endswith(".hand - robot.held")


def test_a_rod_held_by_both_and_a_gripper_that_has_released():
    scene = Scene()
    rod = scene.add_rod(HAND + [0.03 + 0.06, 0, 0], Rotation.from_euler("y", 90, degrees=True))
    scene.add_grip(0, rod)
    scene.scenario.object[rod].held_by_robot = True
    scene.set_hand(HAND + [0.2, 0, 0])
    expected_m = pytest.approx(0.2 - 0.045 - 0.055, abs=ERROR_M)
    proximity = scene.proximity()
    for robot_holds, person_holds in ((True, False), (True, True), (False, True)):
        scene.hold(ROBOT, rod, robot_holds)
        scene.hold(0, rod, person_holds)
        assert scene.measure(proximity)[:2] == (expected_m, "person.hand - robot.gripper")
    # A rod that only the person holds must not hit the torso.
    scene.set_hand((0.5, 0.3, 0.1))
    scene.set_pose(scene.scene.object[rod], (0.015 + 0.1 + 0.02, 0, 0.1), Rotation.from_euler("y", 90, degrees=True))
    assert scene.measure(proximity)[:2] == (pytest.approx(0.02, abs=ERROR_M), "person.held - robot.torso")


# ---- the robot with itself


def test_forearm_beside_the_torso():
    """The forearm's axis is 111 mm from the torso's middle plane, and its radius is 20 mm. The torso extends to 75 mm
    from this plane, and the elbow is level with the torso."""
    assert Scene().measure()[2:] == (pytest.approx(0.111 - 0.020 - 0.075, abs=ERROR_M), "robot.forearm - robot.torso")


def test_a_held_rod_counts_as_the_arm():
    scene = Scene()
    rod = scene.add_rod((0.015 + 0.01 + 0.004, 0, 0.08))
    scene.hold(ROBOT, rod)
    assert scene.measure()[2:] == (pytest.approx(0.004, abs=ERROR_M), "robot.held - robot.torso")
    scene.hold(ROBOT, rod, False)
    assert scene.measure()[3] == "robot.forearm - robot.torso"


def test_neighbouring_parts_never_count_as_touching(rng):
    """Neighbouring parts, which touch in every posture, are not compared, so an arm stretched sideways touches
    nothing."""
    scene = Scene()
    scene.set_posture((0, -90, 0, 0))
    assert scene.measure()[2] > 0.05


# ---- the search


def busy_scene(rng) -> Scene:
    scene = Scene(people=2)
    scene.scenario.cup.present, scene.scenario.person[0].cup.present = True, True
    for cup in (scene.scenario.cup, scene.scenario.person[0].cup):
        cup.radius_m, cup.height_m, cup.wall_m = 0.03, 0.06, 0.002
    scene.scenario.person[0].cup.mount.rotation = [1, 0, 0, 0]
    for i in range(2):
        scene.set_pose(scene.scenario.person[i].start, (0.4, 0.1 * i, 0.1), FACING)
        scene.scenario.person[i].elbow_m = [0.7, 0.1 * i, 0.0]
    scene.add_rod((0.2, -0.1, 0.0), Rotation.random(rng=rng))
    scene.add_rod((0.3, -0.2, 0.1), Rotation.random(rng=rng), length_m=0.3)
    return scene


def test_the_search_of_a_moving_scene_equals_a_fresh_one(rng):
    """A search that starts from the result of the last tick saves time but finds the same clearance as a new search,
    even when bodies jump or change hands."""
    scene = busy_scene(rng)
    proximity = scene.proximity()
    phase, speed = rng.uniform(0, 6, 30), rng.uniform(0.5, 6, 30)
    pairs, jump = set(), 0.0
    for tick in range(1500):
        now = tick * 0.002
        wave = np.sin(phase + speed * now)
        if tick % 250 == 249:
            jump = rng.uniform(-0.2, 0.2)
        scene.set_posture(np.array([50, -45, 0, -60]) + 30 * wave[:4])
        scene.set_pose(scene.scene.robot_cup, HAND + 0.1 * wave[4:7], Rotation.from_rotvec(wave[7:10]))
        for i in range(2):
            place = [0.25 + jump, -0.15 + 0.1 * i, 0.1] + 0.12 * wave[10 + 6 * i : 13 + 6 * i]
            scene.set_hand(place, Rotation.from_rotvec(1.5 * wave[13 + 6 * i : 16 + 6 * i]), person=i)
            turn = Rotation.from_rotvec(2 * wave[20 + 3 * i : 23 + 3 * i])
            scene.set_pose(scene.scene.object[i], place - [0.1, 0, 0], turn)
        for holder, rod in itertools.product(range(3), range(2)):
            scene.hold(holder, rod, (tick // 100 + holder) % 4 == rod)
        kept, fresh = lib.proximity_measure(proximity), lib.proximity_measure(scene.proximity())
        assert abs(kept.person_m - fresh.person_m) <= 2 * ERROR_M
        assert abs(kept.self_m - fresh.self_m) <= 2 * ERROR_M
        pairs |= {kept.person_pair, kept.self_pair}
    assert len(pairs) > 12


def test_another_rod_in_the_same_hand_is_searched_at_once():
    """A rod near the robot is found at once, however far away the previous rod in the same hand was."""
    scene = Scene()
    far, near = scene.add_rod((2, 2, 2)), scene.add_rod((0.015 + 0.01 + 0.03, 0, 0.05))
    proximity = scene.proximity()
    scene.hold(0, far)
    for _ in range(2):
        assert scene.measure(proximity)[:2] == (1.0, "")
    scene.hold(0, far, False)
    scene.hold(0, near)
    assert scene.measure(proximity)[:2] == (pytest.approx(0.03, abs=ERROR_M), "person.held - robot.torso")


def test_pairs_have_the_dbcs_part_names(dbc):
    scene = Scene(people=2)
    proximity = scene.proximity()
    signal = dbc.get_message_by_name("Clearance").get_signal_by_name
    person, robot = signal("person_part").choices, signal("robot_part").choices
    names = set()
    for pair in range(80):
        parts = lib.proximity_pair(pair)
        name = ffi.string(lib.proximity_pair_name(proximity, pair)).decode()
        names.add(name)
        if parts.person < 0:
            assert name == f"robot.{robot[parts.robot]} - robot.{robot[parts.body]}"
        else:
            assert name == f"{['person', 'taker'][parts.person]}.{person[parts.part]} - robot.{robot[parts.robot]}"
    assert len(names) == 80
    assert ffi.string(lib.proximity_pair_name(proximity, -1)) == b""


# ---- on the bus


class Bus:
    """A bus with a listener that stores (end in ns, decoded frame). Frames are sent as if by the operator."""

    def __init__(self, dbc):
        self.dbc, self.bus, self.received = dbc, ffi.gc(lib.bus_create(lib.CAN_PROFILE_FD), lib.bus_destroy), []
        self._listener = ffi.callback("void(void *, const can_frame_t *, int64_t)", self._on_frame)
        lib.bus_listen(self.bus, self._listener, ffi.NULL)
        self.node = lib.bus_attach(self.bus, ffi.NULL, ffi.NULL)
        self.sender = ffi.new("protocol_sender_t *")

    def _on_frame(self, _context, frame, end_ns):
        data = bytes(frame.data[0 : frame.length])
        message = self.dbc.get_message_by_frame_id(frame.id)
        assert p05.e2e_p05_check(data, 0xC000 | frame.id) or message.name == "GripperCommand"
        values = self.dbc.decode_message(frame.id, data, decode_choices=False)
        self.received.append((end_ns, message.name, values, data[2]))

    def send_command(self, action: int, sequence: int, at_ns: int, spoil: bool) -> None:
        frame = ffi.new("can_frame_t *")
        message = ffi.new("gripper_command_t *", {"action": action, "sequence": sequence})
        assert lib.gripper_command_pack(message, frame) == lib.PROTOCOL_OK
        lib.protocol_protect(self.sender, frame)
        frame.data[4] ^= 0x10 if spoil else 0
        assert lib.bus_send(self.bus, self.node, frame, at_ns)

    def states(self) -> list[dict]:
        return [values for _, name, values, _ in self.received if name == "GripperState"]


def test_clearance_every_4_ms(dbc):
    bus = Bus(dbc)
    node = ffi.gc(lib.proximity_node_create(bus.bus), lib.proximity_node_destroy)
    reported = []
    for tick in range(100):
        person_pair, self_pair = tick % 65 - 1, 63 + tick % 17
        clearance = ffi.new("measured_clearance_t *", {"person_m": 0.9 * tick / 99, "self_m": 1.0 - 0.01 * tick})
        clearance.person_pair, clearance.self_pair = person_pair, self_pair if self_pair > 63 else -1
        reported.append(clearance)
        lib.proximity_node_step(node, clearance, tick * MS, (tick + 1) * MS)
        lib.bus_run_until(bus.bus, (tick + 1) * MS)
    assert [name for _, name, _, _ in bus.received] == ["Clearance"] * 25
    lib.proximity_node_step(node, reported[0], 100 * MS, 112 * MS)  # a longer step sends everything due within it
    lib.bus_run_until(bus.bus, 112 * MS)
    assert len(bus.received) == 28
    reported += [reported[0]] * 12
    assert np.all(np.diff([counter for *_, counter in bus.received]) == 1)
    for k, (end_ns, _, values, _) in enumerate(bus.received):
        clearance = reported[4 * k]
        assert 4 * k * MS < end_ns < 4 * k * MS + 60_000
        assert values["person_m"] == pytest.approx(clearance.person_m, abs=0.5001e-4)
        assert values["self_m"] == pytest.approx(clearance.self_m, abs=0.5001e-4)
        assert values["person_valid"] == (clearance.person_pair >= 0)
        assert values["self_valid"] == (clearance.self_pair >= 0)
        if values["person_valid"]:
            parts = [values[part] for part in ("person", "person_part", "robot_part")]
            assert np.ravel_multi_index(parts, (2, 4, 8)) == clearance.person_pair
        if values["self_valid"]:
            assert 64 + np.ravel_multi_index((values["arm_part"], values["body_part"]), (4, 4)) == clearance.self_pair


class Gripper:
    def __init__(self, dbc, opening=1.0):
        self.bus = Bus(dbc)
        self.scene = ffi.new("struct scene *", {"opening": opening})
        self.node = ffi.gc(lib.gripper_node_create(self.bus.bus, self.scene), lib.gripper_node_destroy)
        self.now_ns = 0

    def run(self, ticks: int) -> None:
        for _ in range(ticks):
            lib.gripper_node_step(self.node, self.now_ns, self.now_ns + MS)
            self.now_ns += MS
            lib.bus_run_until(self.bus.bus, self.now_ns)

    def command(self, action: int, sequence: int, spoil: bool = False) -> None:
        self.bus.send_command(action, sequence, self.now_ns, spoil)
        self.run(1)


def test_gripper_reports_its_state_every_20_ms(dbc):
    gripper = Gripper(dbc)
    gripper.scene.opening, gripper.scene.force_N = 0.3341, 12.34
    gripper.run(101)
    ends = [end for end, *_ in gripper.bus.received]
    assert len(ends) == 6 and all(0 < end - 20 * k * MS < 60_000 for k, end in enumerate(ends))
    for values in gripper.bus.states():
        assert values["opening_percent"] == pytest.approx(33.41, abs=0.2501)
        assert values["force_N"] == pytest.approx(12.34, abs=0.0501)
        assert values["sequence"] == 0
    lib.gripper_node_step(gripper.node, 101 * MS, 160 * MS)
    lib.bus_run_until(gripper.bus.bus, 160 * MS)
    assert len(gripper.bus.received) == 8


def test_gripper_executes_and_answers_at_once(dbc):
    gripper = Gripper(dbc)
    gripper.run(5)
    for sequence, action in ((7, 1), (8, 0), (8, 0), (255, 1)):
        before, commands, sent_ns = len(gripper.bus.received), gripper.scene.commands, gripper.now_ns
        gripper.command(action, sequence)
        assert (gripper.scene.commands, gripper.scene.close) == (commands + 1, bool(action))
        (_, first, _, _), (end_ns, second, values, _) = gripper.bus.received[before:]
        assert (first, second, values["sequence"]) == ("GripperCommand", "GripperState", sequence)
        assert end_ns - sent_ns < 200_000
    gripper.run(40)
    assert {values["sequence"] for values in gripper.bus.states()[-2:]} == {255}
    assert lib.gripper_node_rejected(gripper.node) == 0


def test_gripper_refuses_damaged_and_unknown_commands(dbc):
    gripper = Gripper(dbc)
    gripper.run(1)
    states = len(gripper.bus.states())
    gripper.command(1, 4, spoil=True)
    gripper.command(2, 5)
    assert gripper.scene.commands == 0
    assert lib.gripper_node_rejected(gripper.node) == 2
    assert len(gripper.bus.states()) == states


MOVING, OPEN, CLOSED, HOLDING = range(4)


@pytest.mark.parametrize(
    ("action", "opening", "holds", "state"),
    [
        (None, 1.0, False, OPEN), (None, 0.0, False, CLOSED), (None, 0.2, True, HOLDING), (None, 0.5, False, MOVING),
        (1, 1.0, False, MOVING), (1, 0.5, False, MOVING), (1, 0.0, False, CLOSED), (1, 0.2, True, HOLDING),
        (0, 0.0, False, MOVING), (0, 0.5, False, MOVING), (0, 1.0, False, OPEN),
    ],
)  # fmt: skip
def test_states_of_the_gripper(dbc, action, opening, holds, state):
    gripper = Gripper(dbc, opening)
    gripper.scene.holds[ROBOT][3] = holds
    gripper.run(1)
    if action is not None:
        gripper.command(action, 1)
    assert gripper.bus.states()[-1]["state"] == state


def test_the_firmware_ignores_the_simulators_frames(dbc):
    """Frames that only concern the simulator's nodes do not count as refused when they reach the firmware, do not
    appear in TickTrace and do not change any command."""
    benches = [controller_bench.Bench().until_ready().start(core.TASK_TELEOP) for _ in range(2)]
    for tick in range(200):
        for name, kind in (("clearance", "clearance_t"), ("gripper_state", "gripper_state_t"),
                           ("gripper_command", "gripper_command_t")):  # fmt: skip
            frame = core_ffi.new("can_frame_t *")
            assert getattr(core, f"{name}_pack")(core_ffi.new(f"{kind} *"), frame) == core.PROTOCOL_OK
            benches[0].requests.append(frame)
        for bench in benches:
            bench.move_hand([1e-4 * np.sin(0.1 * tick), 0, 0])
            bench.tick()
        assert benches[0].sent == benches[1].sent
    assert benches[0].controller.receiver.protocol.rejected == 0
    assert benches[0].mode == core.MODE_COOPERATING
