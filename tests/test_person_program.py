"""People's programs in a scene without physics (stand_in_scene.c): moves, waits and corrections, and how the programs
fail.

Person.run() returns the hand's pose at the end of each physics step, one row per step."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sim_binding import load

ffi, lib = load()

ACTIONS = ("rest", "move", "reach", "guide", "play", "grip", "release", "turn")
START_M, GRIP_M = np.array([0.5, -0.1, 0.2]), np.array([0.02, 0.0, 0.08])
START = Rotation.from_rotvec([0.2, -1.3, 0.4])
PIPE_M = np.array([0.3, 0.2, 0.1])
PIPE = Rotation.from_rotvec([0.7, 0.1, -0.3])


def share(x):
    x = np.clip(x, 0, 1)
    return 10 * x**3 - 15 * x**4 + 6 * x**5


def wxyz(rotation: Rotation) -> list[float]:
    return rotation.as_quat(scalar_first=True).tolist()


class Person:
    """A scenario with a pipe (object 0, with its point "end" 0.2 m along its axis), a crank (object 1), and a person
    with the given program steps. The steps are dicts of person_step_t fields, with `action` and `awaited` events given
    by name."""

    def __init__(self, *steps, recording=None, axes=None, tremor_mm=0.0, seed=1, recorded=()):
        self.scenario = ffi.new("scenario_t *", {"name": b"test", "person_count": 2, "object_count": 2})
        self.events = ffi.new("events_t *")
        lib.events_init(self.events)
        hand = {"position_m": START_M.tolist(), "rotation": wxyz(START)}
        for i, name in enumerate((b"ann", b"bob")):
            person = self.scenario.person[i]
            person.name, person.start, person.grip_m, person.tremor_mm = name, hand, GRIP_M.tolist(), tremor_mm
            person.done_event = lib.events_declare(self.events, name, b"done")
        pipe = {"position_m": PIPE_M.tolist(), "rotation": wxyz(PIPE)}
        self.scenario.object[0] = {
            "name": b"pipe",
            "kind": lib.OBJECT_ROD,
            "pose": pipe,
            "length_m": 0.4,
            "point": [{"name": b"end", "along_m": 0.2}],
            "point_count": 1,
        }
        self.scenario.object[1] = {
            "name": b"crank",
            "kind": lib.OBJECT_CRANK,
            "pose": pipe,
            "length_m": 0.1,
            "radius_m": 0.06,
        }
        person = self.scenario.person[0]
        person.step_count, person.recorded_step_count = len(steps), len(recorded)
        for target, source in ((person.step, steps), (person.recorded_step, recorded)):
            for n, step in enumerate(source):
                target[n] = self._step(step)
        self.scene = ffi.gc(lib.scene_create(self.scenario, self.events), lib.scene_destroy)
        self.state = lib.stand_in_scene_state(self.scene)
        self.state.gripper_follows = [1, 1, 1]
        self.now_s, error = 0.0, ffi.new("char[]", 400)
        texts = (recording, axes)
        self._texts = [ffi.NULL if text is None else ffi.new("char[]", str(text).encode()) for text in texts]
        program = lib.person_program_create(self.scenario, 0, self.scene, self.events, *self._texts, seed, error, 400)
        self.error = ffi.string(error).decode()
        self.program = None if program == ffi.NULL else ffi.gc(program, lib.person_program_destroy)

    def _step(self, step):
        step = dict(step)
        start = {name: step.pop(name) for name in ("at_s", "delay_s", "patience_s") if name in step}
        awaited = [self.declare(name) for name in step.pop("awaited", ())]
        step["action"] = ACTIONS.index(step["action"])
        step["name"] = step.get("name", "").encode()
        step["recording"] = str(step.get("recording", "")).encode()
        if step["name"]:
            self.declare(f"ann.{step['name'].decode()}")
        return {**step, "start": {**start, "awaited": awaited, "awaited_count": len(awaited)}}

    def declare(self, name: str) -> int:
        return lib.events_declare(self.events, *(part.encode() for part in name.split(".")))

    def raise_event(self, name: str):
        lib.events_raise(self.events, self.declare(name), self.now_s)

    def time_of(self, name: str) -> float | None:
        event = self.events.event[lib.events_find(self.events, name.encode())]
        return event.first_s if event.times else None

    def run(self, until_s, step_s=0.001, follows=(1, 1, 1), before=lambda _now_s: None):
        """Returns time, position and rotation of the hand at the end of each step."""
        rows = []
        for n in range(round(self.now_s / step_s), round(until_s / step_s)):
            self.now_s = n * step_s
            before(self.now_s)
            lib.person_program_step(self.program, self.now_s, (n + 1) * step_s, list(follows))
            pose = self.state.hand[0]
            rows.append([(n + 1) * step_s, *pose.position_m, *pose.rotation])
            self.now_s = (n + 1) * step_s
        rows = np.array(rows)
        return rows[:, 0], rows[:, 1:4], Rotation.from_quat(rows[:, 4:], scalar_first=True)

    @property
    def failure(self) -> str | None:
        text = lib.person_program_failure(self.program)
        return None if text == ffi.NULL else ffi.string(text).decode()

    @property
    def done(self) -> bool:
        return lib.person_program_is_done(self.program)

    def grip_m(self):
        hand = self.state.hand[0]
        rotation = Rotation.from_quat(list(hand.rotation), scalar_first=True)
        return np.array(list(hand.position_m)) + rotation.apply(GRIP_M)


PIPE_END = {"kind": lib.POINT_OBJECT, "index": 0, "point": 0}
PIPE_END_M = PIPE_M + PIPE.apply([0, 0, 0.2])
BOBS_GRIP = {"kind": lib.POINT_PERSON_GRIP, "index": 1}
GRIPPER = {"kind": lib.POINT_ROBOT_GRIPPER}


# ---- moves and waits


@pytest.mark.parametrize("step_s", [0.0005, 0.001, 0.002])
def test_moves_are_minimum_jerk_for_any_step_size(step_s):
    """The first move begins at the start, and the second at the moment when the first ends, even if this moment lies
    between two steps of the simulation. Both moves have a minimum-jerk profile for any step size."""
    turn, turn_on = Rotation.from_rotvec([0.5, 0.2, -0.4]), Rotation.from_rotvec([-0.3, 0.9, 0.1])
    person = Person(
        {
            "action": "move",
            "duration_s": 0.4015,
            "displacement_m": [0.1, 0, -0.05],
            "rotation_vector_rad": turn.as_rotvec().tolist(),
            "name": "first",
        },
        {
            "action": "move",
            "duration_s": 0.5,
            "displacement_m": [0, 0.1, 0],
            "from_here": True,
            "rotation_vector_rad": turn_on.as_rotvec().tolist(),
        },
        {"action": "move", "duration_s": 0.3, "displacement_m": [0, 0, 0], "at_s": 1.1},
    )
    t, position_m, rotation = person.run(1.6, step_s)
    ways_m = np.array([[0.1, 0, -0.05], [0, 0.1, 0], [-0.1, -0.1, 0.05]])
    begins_s, durations_s = (0, 0.4015, 1.1), (0.4015, 0.5, 0.3)
    shares = [share((t - begin) / duration) for begin, duration in zip(begins_s, durations_s, strict=True)]
    expected_m = START_M + sum(s[:, None] * way for s, way in zip(shares, ways_m, strict=True))
    # The position may be off only in the step in which one move ends and the next begins, by the small displacement at
    # the start of a move, 10 x^3 of the whole displacement after the fraction x of the duration.
    np.testing.assert_allclose(position_m, expected_m, atol=10 * (step_s / 0.5) ** 3 * 0.1 + 1e-12)
    np.testing.assert_allclose(position_m[t > 0.41], expected_m[t > 0.41], atol=1e-12)
    first = Rotation.from_rotvec(shares[0][:, None] * turn.as_rotvec()) * START
    assert (rotation[t < 0.4].inv() * first[t < 0.4]).magnitude().max() < 1e-7
    assert (rotation[np.argmax(t > 1.0)].inv() * turn_on * turn * START).magnitude() < 1e-7
    assert (rotation[-1].inv() * START).magnitude() < 1e-7
    assert person.done and person.failure is None
    assert person.time_of("ann.first") == pytest.approx(0.4015)
    assert person.time_of("ann.done") == pytest.approx(1.4)


def test_a_move_turns_in_the_shorter_direction():
    """To turn by 3.6 rad about an axis, the person turns by 2 pi - 3.6 rad in the other direction."""
    axis = np.array([0.6, 0.0, 0.8])
    person = Person({"action": "move", "duration_s": 1.0, "rotation_vector_rad": (3.6 * axis).tolist()})
    t, _, rotation = person.run(1.0)
    expected = Rotation.from_rotvec(np.outer(share(t) * (3.6 - 2 * np.pi), axis)) * START
    assert (rotation.inv() * expected).magnitude().max() < 1e-7


def test_a_step_waits_for_its_time_its_events_and_its_delay():
    move = {"action": "move", "duration_s": 0.1, "displacement_m": [0.1, 0, 0], "from_here": True}
    person = Person(
        {**move, "at_s": 0.2},
        {**move, "awaited": ["bob.there", "robot.holds"], "delay_s": 0.15},
        {**move, "delay_s": 0.05},
        {**move, "awaited": ["bob.there"], "at_s": 0.3, "patience_s": 0.1},
    )

    def before(now_s):
        if now_s == 0.25:
            person.raise_event("bob.there")
        if now_s == 0.5:
            person.raise_event("robot.holds")

    t, position_m, _ = person.run(1.3, before=before)
    begins_s = (0.2, 0.65, 0.8, 0.9)  # 0.2; 0.5 + 0.15; 0.75 + 0.05; at once, since bob.there came before
    expected_m = START_M[0] + 0.1 * sum(share((t - begin) / 0.1) for begin in begins_s)
    np.testing.assert_allclose(position_m[:, 0], expected_m, atol=1e-12)
    assert person.done


def test_a_timeout_names_the_missing_event():
    person = Person(
        {"action": "rest", "duration_s": 0.2},
        {"action": "rest", "awaited": ["bob.there", "robot.holds"], "patience_s": 0.5},
    )
    person.raise_event("bob.there")
    person.run(0.7)
    assert person.failure is None
    person.run(0.71)
    assert person.failure == "ann: timed out after 0.5 s waiting for robot.holds"
    assert not person.done


def test_without_a_timeout_it_waits_forever_at_rest():
    person = Person({"action": "move", "awaited": ["bob.there"], "duration_s": 1, "displacement_m": [1, 0, 0]})
    _, position_m, _ = person.run(20, step_s=0.002)
    assert person.failure is None and not person.done
    np.testing.assert_array_equal(position_m, np.tile(START_M, (len(position_m), 1)))


def test_empty_program_is_done_at_once():
    person = Person()
    assert person.done and person.time_of("ann.done") == 0


# ---- reaching and guiding


def test_reach_corrects_for_a_sagging_arm():
    """The first move follows an arc of the given height. Corrections of 0.4 s follow, each by the remaining distance,
    until the hand is close enough to the goal."""
    reach = {"action": "reach", "to": PIPE_END, "offset_m": [0, 0, 0.03], "duration_s": 1.0, "lift_m": 0.05}
    person = Person({**reach, "tolerance_m": 0.001, "name": "there"})
    goal_m = PIPE_END_M + [0, 0, 0.03]
    way_m = goal_m - START.apply(GRIP_M) - START_M

    def before(now_s):
        if now_s >= 0.9:
            person.state.sag_m[0] = [0.0, 0.003, -0.004]

    t, position_m, rotation = person.run(2, before=before)
    middle_m = position_m[np.argmin(np.abs(t - 0.5))]
    np.testing.assert_allclose(middle_m, START_M + way_m / 2 + [0, 0, 0.05], atol=1e-9)
    np.testing.assert_allclose(person.grip_m(), goal_m, atol=1e-9)
    assert person.time_of("ann.there") == pytest.approx(1.4)
    assert (rotation.inv() * START).magnitude().max() < 1e-9


def test_reach_needs_no_correction_within_its_tolerance():
    person = Person({"action": "reach", "to": PIPE_END, "duration_s": 1.0, "tolerance_m": 0.006})
    person.state.sag_m[0] = [0, 0, 0]

    def before(now_s):
        person.state.sag_m[0] = [0, 0.003, -0.004] if now_s > 0.5 else [0, 0, 0]

    person.run(1.1, before=before)
    assert person.time_of("ann.done") == pytest.approx(1.0)
    assert np.linalg.norm(person.grip_m() - PIPE_END_M) == pytest.approx(0.005)


def test_reach_finds_a_point_that_moved_away():
    person = Person({"action": "reach", "to": BOBS_GRIP, "duration_s": 1.0, "tolerance_m": 0.002})

    def before(now_s):
        person.state.hand[1].position_m = (START_M + min(now_s, 1.2) * np.array([0.05, 0.1, 0])).tolist()

    person.run(3, before=before)
    bob_m = START_M + [0.06, 0.12, 0] + START.apply(GRIP_M)
    np.testing.assert_allclose(person.grip_m(), bob_m, atol=1e-9)
    assert person.time_of("ann.done") == pytest.approx(1.8)  # at 1.4 s the hand was still 20 mm off


def test_reach_gives_up_after_ten_corrections():
    """A point that moves away at 0.1 m/s is still 40 mm away after each correction of 0.4 s, so reach gives up after
    ten corrections."""
    person = Person({"action": "reach", "to": PIPE_END, "duration_s": 1.0, "tolerance_m": 0.003})

    def before(now_s):
        person.state.object[0].position_m = (PIPE_M + [0.1 * now_s, 0, 0]).tolist()

    person.run(6, before=before)
    assert person.failure == (
        "ann: cannot bring ann's grip to pipe.end: 40.0 mm off after 10 corrections, expected at most 3 mm"
    )


@pytest.mark.parametrize("follows", [(1, 1, 1), (-0.5, 0.5, 0.5)])
def test_guide_moves_the_hand_until_the_robot_arrives(follows):
    """The robot moves only 0.8 of the expected displacement, so each correction leaves 20 %: 20 mm after the first
    move, then 4 mm and 0.8 mm. Before each check, the robot has 0.15 s to settle."""
    person = Person(
        {
            "action": "guide",
            "what": GRIPPER,
            "to": PIPE_END,
            "offset_m": [0, 0, 0.02],
            "duration_s": 1.0,
            "tolerance_m": 0.001,
            "lift_m": 0.04,
            "name": "there",
        }
    )
    goal_m = PIPE_END_M + [0, 0, 0.02]
    start_m = goal_m - [0.06, -0.08, 0]
    person.state.gripper_start_m = start_m.tolist()
    person.state.gripper_follows = (0.8 * np.array(follows)).tolist()
    t, position_m, _ = person.run(3.5, follows=follows)
    gripper_m = start_m + 0.8 * np.array(follows) * (position_m - START_M)
    assert np.linalg.norm(gripper_m[-1] - goal_m) == pytest.approx(0.0008)
    middle_m = gripper_m[np.argmin(np.abs(t - 0.5))]
    np.testing.assert_allclose(middle_m, start_m + 0.8 * ((goal_m - start_m) / 2 + [0, 0, 0.04]), atol=1e-9)
    assert person.time_of("ann.there") == pytest.approx(1.15 + 2 * 0.55, abs=0.0011)


FALLING = [  # program step, and the part of the failure message that names what is to be brought where
    ({"action": "guide", "what": GRIPPER, "to": PIPE_END, "duration_s": 1.0, "tolerance_m": 0.001},
     "the robot's gripper to pipe.end"),
    ({"action": "guide", "what": PIPE_END, "to": BOBS_GRIP, "duration_s": 1.0, "tolerance_m": 0.001},
     "pipe.end to bob's grip"),
    ({"action": "reach", "to": PIPE_END, "duration_s": 1.0, "tolerance_m": 0.001}, "ann's grip to pipe.end"),
]  # fmt: skip


@pytest.mark.parametrize(("step", "way"), FALLING)
@pytest.mark.parametrize("is_forbidden", [True, False])
def test_a_fallen_object_is_not_fetched_unless_it_may_fall(step, way, is_forbidden):
    """When the object falls at 0.3 s, in the middle of the move, the person gives up, unless the scenario allows the
    object to fall."""
    person = Person({**step, "name": "there"})
    dropped = person.declare("pipe.dropped")
    if is_forbidden:
        person.scenario.check[0] = {"measure": lib.MEASURE_DROPS, "object": 0, "limit": 0}
        person.scenario.check_count = 1

    def before(now_s):
        if now_s == pytest.approx(0.3):
            lib.events_raise(person.events, dropped, now_s)

    person.run(0.29, before=before)
    assert person.failure is None
    person.run(0.4, before=before)
    assert person.failure == (f"ann: cannot bring {way}: it has fallen" if is_forbidden else None)


def test_guide_refuses_a_robot_that_does_not_follow():
    person = Person({"action": "guide", "what": GRIPPER, "to": PIPE_END, "duration_s": 1.0, "tolerance_m": 0.001})
    _, position_m, _ = person.run(0.1, follows=(1, 0, 1))
    assert (
        person.failure
        == "ann: cannot guide the robot: along y it moves 0 m per m of the hand, expected at least 0.001 m"
    )
    np.testing.assert_array_equal(position_m, np.tile(START_M, (len(position_m), 1)))


# ---- gripping and turning


def test_grip_is_retried_for_a_while_and_release_opens():
    person = Person(
        {"action": "grip", "object": 0, "name": "gripped"}, {"action": "rest", "duration_s": 0.5}, {"action": "release"}
    )

    def before(now_s):
        person.state.can_grip = now_s >= 0.2

    person.run(0.6, before=before)
    assert person.time_of("ann.gripped") == pytest.approx(0.2)
    assert (person.state.closings, person.state.openings) == (201, 0)
    person.run(0.8)
    assert person.state.openings == 1 and person.time_of("ann.done") == pytest.approx(0.7)


@pytest.mark.parametrize(("object_", "name"), [(0, "pipe"), (1, "crank")])
def test_a_failed_grip_reports_the_distance(object_, name):
    person = Person({"action": "grip", "object": object_})
    person.state.crank_turns = 0.25
    person.run(0.4)
    grip_m = START_M + START.apply(GRIP_M)
    middle_m = PIPE_M + (PIPE.apply([0, 0.06, 0]) if object_ == 1 else 0)
    half_m = 0.05 if object_ == 1 else 0.2
    along_m = np.clip((grip_m - middle_m) @ PIPE.apply([0, 0, 1]), -half_m, half_m)
    distance_mm = 1e3 * np.linalg.norm(grip_m - middle_m - along_m * PIPE.apply([0, 0, 1]))
    assert person.failure == f"ann: cannot grip {name}: it is {distance_mm:.0f} mm away"


def test_a_hand_that_holds_an_object_cannot_grip():
    person = Person({"action": "grip", "object": 0})
    person.state.holds[1] = True
    person.run(0.4)
    assert person.failure == "ann: cannot grip pipe: the hand already holds crank"


@pytest.mark.parametrize("turns", [3.0, -1.5, 0.5])
def test_turn_takes_the_hand_around_with_the_handle(turns):
    person = Person({"action": "turn", "object": 1, "turns": turns, "duration_s": 2.0})
    person.state.crank_turns = 0.1  # the current angle of the crank, not an earlier one
    whole_rad, start_rad = 2 * np.pi * turns, 0.2 * np.pi
    t, position_m, rotation = person.run(9)

    from_hinge = PIPE.inv().apply(position_m - START_M) + 0.06 * np.array([np.cos(start_rad), np.sin(start_rad), 0])
    np.testing.assert_allclose(np.hypot(from_hinge[:, 0], from_hinge[:, 1]), 0.06, atol=1e-12)
    np.testing.assert_allclose(from_hinge[:, 2], 0, atol=1e-12)
    angle_rad = np.unwrap(np.arctan2(from_hinge[:, 1], from_hinge[:, 0])) - start_rad
    assert angle_rad[-1] == pytest.approx(whole_rad)
    speed_radps = np.sign(turns) * np.gradient(angle_rad, t)
    assert speed_radps.min() > -1e-9 and speed_radps.max() == pytest.approx(np.pi, rel=1e-3), "at most one turn in 2 s"
    assert np.abs(np.gradient(speed_radps, t)).max() < 1.05 * 1.875 * np.pi / min(2.0, 2 * abs(turns))
    assert np.abs(angle_rad[t <= 0.05]).max() < 1e-3, "starts smoothly"
    assert (rotation.inv() * START).magnitude().max() < 1e-9
    duration_s = abs(turns) * 2.0 + min(2.0, 2.0 * abs(turns))
    assert person.time_of("ann.done") == pytest.approx(duration_s)


# ---- recordings and tremor


def write(path, times_s, x_m):
    rows = [f"{t},{x},0,0,1,0,0,0" for t, x in zip(times_s, x_m, strict=True)]
    path.write_text("\n".join(["t_s,x_m,y_m,z_m,qw,qx,qy,qz", *rows]))
    return path


def play(**changes):
    return {"action": "play", "position_scale": 0.5, "rotation_scale": 1.0, **changes}


def test_recorded_steps_play_the_recording_from_here(tmp_path):
    """Recorded steps play the recording from where a move left the hand, with the axes given on the command line. In a
    gap of the recording the hand continues to move, but is hidden."""
    times_s = [i / 100 for i in range(201) if not 60 < i < 80]
    path = write(tmp_path / "hand.csv", times_s, times_s)
    person = Person(
        {"action": "rest", "duration_s": 99},
        recording=path,
        axes="-yxz",
        recorded=[
            {"action": "move", "duration_s": 0.5, "displacement_m": [0, 0, 0.1]},
            play(from_s=0.2, until_s=1.5),
            {"action": "rest", "duration_s": 0.1},
        ],
    )
    hidden = []
    t, position_m, _ = person.run(2.1, before=lambda _: hidden.append(lib.person_program_is_hidden(person.program)))
    played = np.clip(t - 0.5, 0, 1.3)
    expected_m = START_M + np.outer(share(t / 0.5), [0, 0, 0.1]) + np.outer(0.5 * played, [0, 1, 0])
    np.testing.assert_allclose(position_m, expected_m, atol=1e-9)
    hidden_ms = set(np.flatnonzero(hidden))  # entry n was appended before step n, at n ms
    assert hidden_ms | {900, 1100} == set(range(900, 1101)), "rounding decides the ends of the gap"
    assert person.time_of("ann.done") == pytest.approx(1.9)
    description = ffi.string(lib.person_program_description(person.program)).decode()
    assert description.startswith(f"ann: recording {path}: samples 182, 2.00 s, 100.0 Hz, gaps 1 (longest 200 ms)")
    assert description.endswith("played from 0.20 s until 1.50 s, positions times 0.5, rotations times 1")


def test_recording_of_the_step_itself(tmp_path):
    path = write(tmp_path / "hand.csv", [0, 0.5, 1], [0, 1, 2])
    person = Person(play(recording=path))
    person.run(1.2)
    assert person.done
    np.testing.assert_allclose(list(person.state.hand[0].position_m), START_M + [1, 0, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("step", "error"),
    [
        (play(), "ann: step 1 plays a recording, expected the path of a CSV file in its key `recording`"),
        (play(recording="/missing.csv"), "/missing.csv: cannot be read: No such file or directory"),
        (
            play(from_s=5, recording="PATH"),
            "PATH: from_s 5, until_s 1: expected 0 <= from_s < until_s <= 1, the duration in s",
        ),
        (
            play(until_s=2, recording="PATH"),
            "PATH: from_s 0, until_s 2: expected 0 <= from_s < until_s <= 1, the duration in s",
        ),
    ],
)
def test_recordings_that_cannot_be_played_are_named(tmp_path, step, error):
    path = str(write(tmp_path / "hand.csv", [0, 0.5, 1], [0, 1, 2]))
    person = Person({**step, "recording": step.get("recording", "").replace("PATH", path)})
    assert person.program is None and person.error == error.replace("PATH", path)


def test_recording_without_steps_for_it(tmp_path):
    person = Person({"action": "rest"}, recording="hand.csv")
    assert person.program is None
    assert person.error == "hand.csv: ann of scenario test has no program_with_recording to play it"


def test_tremor_is_added_to_whatever_the_hand_does():
    steps = [{"action": "move", "duration_s": 1, "displacement_m": [0.1, 0, 0]}, {"action": "rest", "duration_s": 1}]
    t, still_m, _ = Person(*steps).run(3)
    _, trembling_m, _ = Person(*steps, tremor_mm=0.1, seed=7).run(3)
    tremor, displacement_m = ffi.new("tremor_t *"), ffi.new("double[3]")
    lib.tremor_init(tremor, 1e-4, 7, b"ann")
    expected_m = []
    for time_s in t:
        lib.tremor_sample(tremor, time_s, displacement_m)
        expected_m.append(list(displacement_m))
    np.testing.assert_allclose(trembling_m - still_m, expected_m, atol=1e-15)
    assert np.abs(trembling_m - still_m)[t > 2].max() > 5e-5
