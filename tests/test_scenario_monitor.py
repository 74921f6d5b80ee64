"""The monitors agree with numpy on synthetic ticks: each measure of a scenario's checks, its window and missing
measurements, forces and clearances of a run, and the scene's state with its columns in the trace."""

from __future__ import annotations

import csv
from dataclasses import dataclass, field

import monitor_binding
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

TICK_S = 0.001
READY, COOPERATING, HOLD = 1, 2, 3  # numbers of FirmwareStatus.mode
PERSON, SECOND, ROBOT = 0, 1, 2  # indices of the holders
NO_EVENT = -1

ffi, lib = monitor_binding.load()


@dataclass(frozen=True)
class Check:
    """One check of a scenario. `since` and `until` are a time [s], the name of an event, or a pair (name, seconds after
    it)."""

    measure: str
    since: float | str | tuple[str, float] | None = None
    until: float | str | tuple[str, float] | None = None
    expected_m: tuple[float, float, float] = (0, 0, 0)
    expected_deg: float = 0
    object: int = 0
    person: int = 0


@dataclass
class Tick:
    """The state of the scene in one tick. Rotations are scipy objects."""

    mode: int = COOPERATING
    hand_m: np.ndarray = field(default_factory=lambda: np.zeros(3))
    hand: Rotation = field(default_factory=Rotation.identity)
    target_m: np.ndarray | None = None
    target: Rotation = field(default_factory=Rotation.identity)
    person_m: np.ndarray = field(default_factory=lambda: np.zeros(3))
    force_N: np.ndarray = field(default_factory=lambda: np.zeros(3))
    holds: tuple[tuple[int, int], ...] = ()  # pairs (holder, object)
    cup: Rotation = field(default_factory=Rotation.identity)
    # numbers of particles in the robot's cup, in the person's cup and elsewhere, and of those that have left the
    # robot's cup
    water: tuple[int, int, int, int] = (50, 0, 0, 0)
    turns: float = 0
    clearance_m: tuple[float, float] = (1, 1)
    raises: tuple[str, ...] = ()  # events raised in this tick
    raised_after_s: float = 0  # time from the tick's start to the events


def wxyz(rotation: Rotation) -> list[float]:
    return [float(part) for part in np.roll(rotation.as_quat(), 1)]


class Watch:
    """A scenario monitor with the given checks, for a scenario with two people, two rods and a crank."""

    def __init__(self, *checks: Check, motion_scale: float = 1.0):
        self.motion_scale = motion_scale
        self.scenario = ffi.new("scenario_t *")
        lib.events_init(ffi.addressof(self.scenario, "events"))
        for name in (
            "robot.lost",
            "person.lost",
            "taker.lost",
            "robot.opened",
            "operator.latched",
            "person.done",
            "object0.dropped",
            "object1.dropped",
        ):
            lib.events_declare(ffi.addressof(self.scenario, "events"), *(part.encode() for part in name.split(".")))
        self.scenario.person_count, self.scenario.object_count, self.scenario.check_count = 2, 3, len(checks)
        self.scenario.person[0].name, self.scenario.person[1].name = b"person", b"taker"
        for i in range(3):
            self.scenario.object[i].name = f"object{i}".encode()
        self.scenario.water.particles = 50
        for check, given in zip(self.scenario.check, checks, strict=False):
            check.measure = getattr(lib, f"MEASURE_{given.measure.upper()}")
            check.has_from, check.has_until = given.since is not None, given.until is not None
            self._moment(check, "from", given.since)
            self._moment(check, "until", given.until)
            check.expected_m, check.expected_deg = given.expected_m, given.expected_deg
            check.object, check.person = given.object, given.person
        self.events = ffi.new("events_t *", self.scenario.events)
        self.monitor = ffi.new("scenario_monitor_t *")
        lib.scenario_monitor_init(self.monitor, self.scenario)
        self.ticks = 0

    def _event(self, name: str) -> int:
        number = lib.events_find(ffi.addressof(self.scenario, "events"), name.encode())
        assert number != NO_EVENT, name
        return number

    def _moment(self, check, key: str, given):
        moment = ffi.addressof(check, key)
        name, seconds = given if isinstance(given, tuple) else (given, 0) if isinstance(given, str) else (None, given)
        moment.event, moment.s = NO_EVENT if name is None else self._event(name), seconds or 0

    def sample(self, *ticks: Tick) -> Watch:
        for tick in ticks:
            record, state = ffi.new("tick_record_t *"), ffi.new("physical_state_t *")
            record.time_ns, record.mode = self.ticks * 1_000_000, tick.mode
            record.hand.position_m, record.hand.rotation = list(tick.hand_m), wxyz(tick.hand)
            record.has_target = tick.target_m is not None
            if record.has_target:
                record.target.position_m, record.target.rotation = list(tick.target_m), wxyz(tick.target)
                record.hand_at_target = record.hand
            state.person_count, state.object_count, state.has_water, state.has_robot_cup = 2, 3, True, True
            for person in (PERSON, SECOND):
                state.hand[person].position_m = list(tick.person_m)
            state.hand_force_N[PERSON] = list(tick.force_N)
            for holder, thing in tick.holds:
                state.holds[holder][thing] = True
            state.robot_cup.rotation = wxyz(tick.cup)
            state.water = tick.water
            state.crank_turns[2] = tick.turns
            state.clearance.person_m, state.clearance.self_m = tick.clearance_m
            for name in tick.raises:
                lib.events_raise(self.events, self._event(name), self.ticks * TICK_S + tick.raised_after_s)
            lib.scenario_monitor_sample(self.monitor, record, state, self.events, self.motion_scale)
            self.ticks += 1
        return self

    def value(self, check: int = 0) -> float | None:
        """Returns the value, or None if it was not measured."""
        measurement, definition = (
            ffi.addressof(self.monitor.measurement[check]),
            ffi.addressof(self.scenario.check[check]),
        )
        if not lib.measurement_is_valid(measurement, definition):
            return None
        return lib.measurement_value(measurement, definition)

    def is_complete(self, check: int = 0) -> bool:
        window = ffi.addressof(self.monitor.measurement[check].window)
        return lib.check_window_is_whole(window, ffi.addressof(self.scenario.check[check]))

    def missing(self, check: int = 0) -> str | None:
        definition = ffi.addressof(self.scenario.check[check])
        window = ffi.addressof(self.monitor.measurement[check].window)
        number = lib.check_window_missing_event(window, definition, self.events)
        return None if number == NO_EVENT else ffi.string(self.events.event[number].name).decode()


def random_walk(rng, count):
    return np.cumsum(rng.normal(0, 1e-3, (count, 3)), axis=0)


# ---- the end effector


def test_distance_from_the_target(rng):
    hand, target = random_walk(rng, 400), random_walk(rng, 400)
    watch = Watch(Check("settled_position", 0.1, 0.25), Check("following_rms", 0.1, 0.25), Check("following_rms"))
    watch.sample(*(Tick(hand_m=h, target_m=t) for h, t in zip(hand, target, strict=True)))
    distance_mm = 1e3 * np.linalg.norm(hand - target, axis=1)
    assert watch.value(0) == pytest.approx(distance_mm[100:251].max(), rel=1e-12)
    assert watch.value(1) == pytest.approx(np.sqrt(np.mean(distance_mm[100:251] ** 2)), rel=1e-12)
    assert watch.value(2) == pytest.approx(np.sqrt(np.mean(distance_mm**2)), rel=1e-12)


@pytest.mark.parametrize("motion_scale", [1.0, 0.5])
def test_relation_compares_the_two_hands_displacements(rng, motion_scale):
    """relation_rms compares the displacements of robot and person since the window's start, whatever target the
    firmware reports."""
    robot, person = random_walk(rng, 400), random_walk(rng, 400)
    watch = Watch(Check("relation_rms", 0.1, 0.3), motion_scale=motion_scale)
    watch.sample(*(Tick(hand_m=r, person_m=p) for r, p in zip(robot, person, strict=True)))
    window = slice(100, 301)
    error_mm = 1e3 * ((robot[window] - robot[100]) - motion_scale * (person[window] - person[100]))
    assert watch.value() == pytest.approx(np.sqrt(np.mean((error_mm**2).sum(axis=1))), rel=1e-12)


def test_aim_uses_the_mean_position(rng):
    """Unlike the measure relation_rms, aim compares positions, not displacements since the window's start. It measures
    the mean error, so an error that averages to zero does not count."""
    robot, person, expected_m = random_walk(rng, 400), random_walk(rng, 400), (0.1, -0.2, 0.3)
    watch = Watch(Check("aim", 0.1, 0.3, expected_m=expected_m), motion_scale=0.5)
    watch.sample(*(Tick(hand_m=r, person_m=p) for r, p in zip(robot, person, strict=True)))
    off_m = (robot - person)[100:301].mean(axis=0) - expected_m
    assert watch.value() == pytest.approx(1e3 * np.linalg.norm(off_m), rel=1e-9)


def test_orientation_is_a_rest_beside_the_following(rng):
    angle_deg = rng.uniform(0, 170, 50)
    watch = Watch(Check("following_rms"), Check("settled_position"))
    turned = (Rotation.from_rotvec([0, np.radians(angle), 0]) for angle in angle_deg)
    watch.sample(*(Tick(target_m=np.zeros(3), target=target) for target in turned))
    rest = [
        lib.measurement_orientation_rest_deg(watch.monitor.measurement + i, watch.scenario.check + i) for i in (0, 1)
    ]
    assert rest[0] == pytest.approx(np.sqrt(np.mean(angle_deg**2)), rel=1e-9)
    assert np.isnan(rest[1]) and watch.value(0) == 0


@pytest.mark.parametrize(("with_target", "measured"), [(50, True), (49, False), (0, False)])
def test_half_of_the_window_needs_a_target(with_target, measured):
    ticks = [Tick(target_m=np.full(3, 0.01) if i < with_target else None) for i in range(100)]
    for measure in ("settled_position", "following_rms"):
        value = Watch(Check(measure)).sample(*ticks).value()
        assert value == (pytest.approx(10 * np.sqrt(3)) if measured else None)


@pytest.mark.parametrize("motion_scale", [1.0, 0.4])
def test_displacements_and_paths(rng, motion_scale):
    hand = random_walk(rng, 300)
    expected = np.array([0.03, -0.02, 0.01])
    # `whole` covers ticks 0 to 200, and `part` covers ticks 90 to 240
    whole, part = (None, 0.2), (("operator.latched", 0.05), "person.done")
    checks = [
        Check(measure, *window, expected_m=tuple(expected))
        for window in (whole, part)
        for measure in ("displacement", "way_x", "way_y", "way_z")
    ]
    raises = {40: ("operator.latched",), 240: ("person.done",)}
    ticks = [Tick(hand_m=h, raises=raises.get(i, ())) for i, h in enumerate(hand)]
    watch = Watch(*checks, motion_scale=motion_scale).sample(*ticks)
    for first, way in ((0, hand[200] - hand[0]), (4, hand[240] - hand[90])):
        error_mm = 1e3 * np.linalg.norm(way - motion_scale * expected)
        assert watch.value(first) == pytest.approx(error_mm, rel=1e-12)
        assert [watch.value(first + 1 + k) for k in range(3)] == pytest.approx(1e3 * way, rel=1e-12)


def test_displacement_counts_from_the_start_command():
    ticks = [Tick(READY, hand_m=np.array([5.0, 0, 0])), *(Tick(hand_m=np.array([0.001 * i, 0, 0])) for i in range(11))]
    watch = Watch(Check("way_x"), Check("way_x", until=0.011)).sample(*ticks)
    assert [watch.value(0), watch.value(1)] == pytest.approx([10, 10])


def test_tilt_of_the_initially_vertical_axis(rng):
    """A rotation about a horizontal axis tilts the end effector by its angle, whereas a rotation about the vertical
    axis does not tilt it. The smallest tilt in the window counts."""
    start = Rotation.random(random_state=7)
    angles_deg = rng.uniform(5, 175, 60)
    heading = rng.uniform(0, 2 * np.pi, 60)
    moved = [
        Rotation.from_rotvec(np.radians(angle) * np.array([np.cos(h), np.sin(h), 0])) * Rotation.from_rotvec([0, 0, h])
        for angle, h in zip(angles_deg, heading, strict=True)
    ]
    ticks = [Tick(READY, hand=Rotation.identity()), Tick(hand=start), *(Tick(hand=m * start) for m in moved)]
    watch = Watch(Check("tilt", 0.002), Check("tilt", 0.021, 0.041)).sample(*ticks)
    assert watch.value(0) == pytest.approx(angles_deg.min(), abs=1e-9)
    assert watch.value(1) == pytest.approx(angles_deg[19:40].min(), abs=1e-9)


def test_turn_since_the_start():
    start = Rotation.random(random_state=3)
    turn = Rotation.from_rotvec(np.radians(23) * np.array([0.6, 0, -0.8]))
    watch = Watch(Check("turn", expected_deg=20), Check("turn", until=0.001, expected_deg=20))
    watch.sample(Tick(hand=start), Tick(hand=start), Tick(hand=turn * start))
    assert [watch.value(0), watch.value(1)] == pytest.approx([3, 20], abs=1e-9)


# ---- water


def test_largest_tilt_of_the_cup():
    angles_deg = [0, 20, 41, 38]
    spun = [
        Rotation.from_rotvec([0, np.radians(a), 0]) * Rotation.from_rotvec([0, 0, 0.3 * i])
        for i, a in enumerate(angles_deg)
    ]
    watch = Watch(Check("cup_tilt_peak"), Check("cup_tilt_peak", 0.003)).sample(*(Tick(cup=cup) for cup in spun))
    assert [watch.value(0), watch.value(1)] == pytest.approx([41, 38], abs=1e-9)


def test_water_poured_and_caught():
    counts = [(50, 0, 0, 0), (40, 4, 6, 10), (30, 15, 5, 20), (30, 19, 1, 20)]
    watch = Watch(Check("water_poured"), Check("water_caught"), Check("water_poured", 0.001, 0.002))
    watch.sample(*(Tick(water=count) for count in counts[:3]), Tick(READY, water=counts[3]))
    assert [watch.value(i) for i in range(3)] == pytest.approx([40, 95, 20])


def test_nothing_poured_counts_as_nothing_caught():
    watch = Watch(Check("water_poured"), Check("water_caught")).sample(*[Tick()] * 50)
    assert (watch.value(0), watch.value(1)) == (0, None)


@pytest.mark.parametrize(("speed_mps", "expected"), [(0.0045, 0), (0.0055, 12)])
def test_flow_while_moving(speed_mps, expected):
    """The hand also trembles by 0.1 mm at 9 Hz. The tremor reaches speeds above 5 mm/s, but does not count as
    motion."""
    t_s = TICK_S * np.arange(1000)
    person = np.full((1000, 3), 0.5)
    person[:, 1] += speed_mps * t_s
    person[:, 2] += 0.1e-3 * np.sin(2 * np.pi * 9 * t_s)
    left = np.where(t_s < 0.6, 7, 19)  # seven particles leave before motion can be detected, and twelve after that
    assert np.abs(np.diff(person[:, 2])).max() / TICK_S > 0.005
    ticks = [Tick(person_m=p, water=(50 - int(n), int(n), 0, int(n))) for p, n in zip(person, left, strict=True)]
    assert Watch(Check("flow_while_moving")).sample(*ticks).value() == expected


# ---- objects

BOTH, ALONE, OTHER = ((PERSON, 0), (ROBOT, 0)), ((PERSON, 0),), ((ROBOT, 1),)


def test_each_drop_of_the_object_counts_in_its_window():
    """Each drop is counted in the windows that contain it. The scene decides what counts as a drop (see
    test_scene.py)."""
    watch = Watch(Check("drops"), Check("drops", object=1), Check("drops", object=2), Check("drops", until=0.009))
    watch.sample(
        *[Tick()] * 5, Tick(raises=("object0.dropped",)), *[Tick()] * 5, Tick(raises=("object0.dropped",)), Tick()
    )
    assert [watch.value(i) for i in range(4)] == [2, 0, 0, 1]
    watch.sample(Tick(raises=("object1.dropped",)))
    assert [watch.value(i) for i in range(4)] == [2, 1, 0, 1]


def test_an_object_that_slips_is_lost_by_its_holder():
    """The event robot.lost counts as a drop of object 1, which the robot held. It counts whether it is raised in the
    last tick in which the robot still holds the object or in the first tick after that."""
    held = Tick(holds=(*ALONE, *OTHER))
    watch = Watch(Check("drops", object=0), Check("drops", object=1))
    watch.sample(held, Tick(holds=held.holds, raises=("robot.lost",)), Tick(holds=ALONE))
    assert [watch.value(0), watch.value(1)] == [0, 1]
    watch.sample(held, Tick(holds=ALONE, raises=("robot.lost",)), Tick(holds=ALONE))
    assert [watch.value(0), watch.value(1)] == [0, 2]
    watch.sample(held, Tick(holds=held.holds, raises=("person.lost",)), *[Tick(holds=held.holds)] * 30)
    assert [watch.value(0), watch.value(1)] == [1, 2]
    watch.sample(held, Tick(holds=held.holds, raises=("taker.lost", "robot.opened")), held)
    assert [watch.value(0), watch.value(1)] == [1, 2]
    watch.sample(Tick(holds=ALONE), Tick(holds=held.holds, raises=("robot.lost",)))  # gripped and lost within one tick
    assert [watch.value(0), watch.value(1)] == [1, 3]


def test_dropped_after_the_stop_is_dropped():
    watch = Watch(Check("drops"), Check("held"))
    watch.sample(*[Tick(holds=ALONE)] * 5, *[Tick(READY, holds=ALONE)] * 5)
    assert [watch.value(0), watch.value(1)] == [0, 1]
    watch.sample(*[Tick(READY)] * 20, Tick(READY, raises=("object0.dropped",)))
    assert [watch.value(0), watch.value(1)] == [1, 0]


@pytest.mark.parametrize(
    ("holds", "held"),
    [(ALONE, 1), ((), 0), (BOTH, 0), (((SECOND, 0),), 0), ((*ALONE, (SECOND, 0)), 0), ((*ALONE, *OTHER), 1)],
)
def test_held_by_the_person_alone(holds, held):
    ticks = [*[Tick(holds=ALONE if not held else ())] * 3, Tick(holds=holds)]
    assert Watch(Check("held")).sample(*ticks).value() == held


def test_force_counts_while_the_person_holds_the_object(rng):
    force = rng.normal(0, 5, (400, 3))
    holds = [((PERSON, 0),) if 100 <= i < 350 else ((PERSON, 1),) for i in range(400)]
    ticks = [
        Tick(force_N=f, holds=h, raises=("operator.latched",) if i == 200 else ())
        for i, (f, h) in enumerate(zip(force, holds, strict=True))
    ]
    checks = [Check(m, since) for since in (None, "operator.latched") for m in ("force_rms", "force_peak")]
    watch = Watch(*checks, Check("force_rms", person=1)).sample(*ticks)
    size_N = np.linalg.norm(force, axis=1)
    for check, part in ((0, size_N[100:350]), (2, size_N[200:350])):
        assert watch.value(check) == pytest.approx(np.sqrt(np.mean(part**2)), rel=1e-12)
        assert watch.value(check + 1) == pytest.approx(part.max(), rel=1e-12)
    assert watch.value(4) is None, "no force is measured without an object"


@pytest.mark.parametrize("measure", ["force_rms", "force_peak"])
def test_a_force_that_is_not_a_number_is_reported(measure):
    force = ([1, 0, 0], [np.nan, 0, 0], [2, 0, 0])
    watch = Watch(Check(measure)).sample(*(Tick(force_N=np.array(f), holds=ALONE) for f in force))
    assert np.isnan(watch.value())


def test_turns_of_the_crank():
    ticks = [Tick(turns=0.1 * i) for i in range(32)]
    watch = Watch(Check("turns", object=2), Check("turns", 0.010, 0.020, object=2)).sample(*ticks)
    assert [watch.value(0), watch.value(1)] == pytest.approx([3.1, 1.0])


def test_carried_for_adds_up_the_time_held_by_both():
    ticks = [*[Tick(holds=BOTH)] * 30, *[Tick(holds=ALONE)] * 40, *[Tick(holds=BOTH)] * 25, *[Tick(holds=OTHER)] * 9]
    watch = Watch(Check("carried_for"), Check("carried_for", 0.02, 0.08), Check("carried_for", person=1)).sample(*ticks)
    assert [watch.value(i) for i in range(3)] == pytest.approx([0.055, 0.021, 0])


def test_least_clearances(rng):
    clearance_m = rng.uniform(0, 1, (100, 2))
    clearance_m[0], clearance_m[-1] = 0, 0  # before the start command and after the stop, where clearances do not count
    modes = [READY, *[COOPERATING] * 60, *[HOLD] * 38, READY]
    watch = Watch(Check("clearance"), Check("self_clearance"))
    watch.sample(*(Tick(m, clearance_m=tuple(c)) for m, c in zip(modes, clearance_m, strict=True)))
    assert [watch.value(0), watch.value(1)] == pytest.approx(1e3 * clearance_m[1:99].min(axis=0), rel=1e-12)


# ---- windows


def peak_ticks(count=100, mode=COOPERATING, **at):
    """Returns ticks in which the person's force in newtons equals the tick's number, so that the peak force of a window
    is the number of its last tick."""
    raises = {tick: (name,) for name, tick in at.items()}
    names = {"latched": "operator.latched", "done": "person.done"}
    return [
        Tick(mode, force_N=np.array([i, 0, 0]), holds=ALONE, raises=tuple(names[n] for n in raises.get(i, ())))
        for i in range(count)
    ]


def test_a_window_whose_event_never_happened_is_not_measured():
    for check in (Check("force_peak", "operator.latched"), Check("force_peak", None, "operator.latched")):
        watch = Watch(check).sample(*peak_ticks())
        assert (watch.value(), watch.missing(), watch.is_complete()) == (None, "operator.latched", False)
        watch.sample(Tick(raises=("operator.latched",), holds=ALONE))
        assert watch.value() is not None and watch.missing() is None and watch.is_complete()


def test_a_window_without_its_end_is_not_measured():
    watch = Watch(Check("force_peak", None, 0.1)).sample(*peak_ticks(100))
    assert (watch.value(), watch.missing()) == (None, None)
    assert watch.sample(Tick()).value() == 99


def test_a_window_that_ends_before_its_start_is_not_measured():
    ticks = peak_ticks(latched=50, done=20)
    assert Watch(Check("force_peak", "operator.latched", "person.done")).sample(*ticks).value() is None


@pytest.mark.parametrize(("after_s", "last"), [(0, 50), (0.0004, 50), (0.0006, 51), (0.001, 51)])
def test_window_ends_with_the_tick_nearest_to_its_end_time(after_s, last):
    ticks = peak_ticks(latched=50)
    ticks[50].raised_after_s = after_s
    assert Watch(Check("force_peak", None, "operator.latched")).sample(*ticks).value() == last


@pytest.mark.parametrize(("after_s", "first"), [(0, 50), (0.0004, 50), (0.0006, 51), (0.001, 51)])
def test_window_starts_with_the_tick_nearest_to_its_start_time(after_s, first):
    ticks = [Tick(clearance_m=(0.001 * i, 1), raises=("operator.latched",) if i == 50 else ()) for i in range(100)]
    ticks[50].raised_after_s = after_s
    assert Watch(Check("clearance", "operator.latched")).sample(*ticks).value() == pytest.approx(first)


def test_the_first_occurrence_of_an_event_counts():
    ticks = peak_ticks(latched=30)
    ticks[60].raises = ("operator.latched",)
    assert Watch(Check("force_peak", None, ("operator.latched", 0.01))).sample(*ticks).value() == 40


def test_window_of_the_cooperation_ends_with_the_stop():
    modes = [READY] * 10 + [COOPERATING] * 20 + [HOLD] * 10 + [COOPERATING] * 10 + [READY] * 50
    ticks = peak_ticks()
    for tick, mode in zip(ticks, modes, strict=True):
        tick.mode = mode
    watch = Watch(Check("force_peak"), Check("force_peak", None, 0.080), Check("force_rms")).sample(*ticks)
    assert (watch.value(0), watch.value(1)) == (49, 80)
    assert watch.value(2) == pytest.approx(np.sqrt(np.mean(np.arange(10, 50) ** 2)))


def test_without_cooperation_the_hand_is_not_measured():
    checks = ("settled_position", "displacement", "way_y", "tilt", "turn", "force_rms", "clearance")
    watch = Watch(*map(Check, checks)).sample(*peak_ticks(mode=READY))
    assert [watch.value(i) for i in range(len(checks))] == [None] * len(checks)


def test_every_measure_has_a_unit_or_counts():
    names = [name for name in dir(lib) if name.startswith("MEASURE_")]
    units = {name[8:].lower(): ffi.string(lib.measure_unit(getattr(lib, name))).decode() for name in names}
    counts = {name for name, unit in units.items() if unit == ""}
    assert len(units) == 22 and counts == {"flow_while_moving", "drops", "held"}
    assert {name for name, unit in units.items() if unit == "N"} == {"force_rms", "force_peak"}
    assert {name for name, unit in units.items() if unit == "deg"} == {"tilt", "cup_tilt_peak", "turn"}


# ---- forces and clearances of a run


def test_contacts_of_a_run(rng):
    count = 200
    force, gripper = rng.normal(0, 4, (count, 3)), rng.uniform(0, 9, count)
    clearance = rng.uniform(0.1, 1, (count, 2))
    monitor = ffi.new("contact_monitor_t *")
    lib.contact_monitor_init(monitor)
    assert np.isnan(lib.held_force_rms_N(ffi.addressof(monitor.hand, 0)))
    for i in range(count):
        state, record = ffi.new("physical_state_t *"), ffi.new("tick_record_t *")
        record.time_ns = i * 1_000_000
        state.person_count, state.object_count = 2, 3
        state.holds[PERSON][2] = i >= 50
        state.holds[ROBOT][1] = i < 20
        state.hand_force_N[PERSON], state.gripper_force_N = list(force[i]), gripper[i]
        state.clearance = (*clearance[i], i, 1000 + i)
        lib.contact_monitor_sample(monitor, record, state)
    size_N = np.linalg.norm(force, axis=1)
    hand, second = ffi.addressof(monitor.hand, PERSON), ffi.addressof(monitor.hand, SECOND)
    assert lib.held_force_rms_N(hand) == pytest.approx(np.sqrt(np.mean(size_N[50:] ** 2)), rel=1e-12)
    assert lib.held_force_peak_N(hand) == pytest.approx(size_N[50:].max(), rel=1e-12)
    assert np.isnan(lib.held_force_peak_N(second))
    assert lib.held_force_peak_N(ffi.addressof(monitor, "gripper")) == gripper[:20].max()
    for least, column, first_pair in ((monitor.person, 0, 0), (monitor.self, 1, 1000)):
        when = int(clearance[:, column].argmin())
        assert (least.least_m, least.pair) == (clearance[when, column], first_pair + when)
        assert least.t_s == pytest.approx(when * TICK_S)


# ---- the scene's state and its columns in the trace


def read_scene(people=2, tracked=0, kinds=("STAND", "ROD", "CRANK"), water=True):
    scenario, state = ffi.new("scenario_t *"), ffi.new("physical_state_t *")
    scenario.person_count, scenario.tracked, scenario.object_count = people, tracked, len(kinds)
    for thing, kind in zip(scenario.object, kinds, strict=False):
        thing.kind = getattr(lib, f"OBJECT_{kind}")
    scenario.water.particles, scenario.cup.present = 60 if water else 0, water
    lib.physical_state_read(state, scenario, ffi.NULL, ffi.new("measured_clearance_t *", [0.0215, 0.5, 3, 4]))
    return state


def test_state_of_the_scene():
    state = read_scene(tracked=1)
    assert (state.second, state.traced_object, state.crank) == (0, 1, 2)
    assert [state.hand[i].position_m[0] for i in range(2)] == [10, 11]
    assert [state.object[i].position_m[0] for i in range(3)] == [20, 21, 22]
    assert list(state.crank_turns) == [0, 0, 2.5, 0, 0, 0, 0, 0]
    assert [[state.holds[h][o] for o in range(3)] for h in range(3)] == [
        [True, False, False], [False, True, False], [False, False, True],
    ]  # fmt: skip
    assert lib.physical_state_force_N(state, 1) == pytest.approx(2 * np.sqrt(14))
    assert list(state.robot_cup.position_m) == [1, 2, 3]
    assert (state.gripper_opening, state.gripper_force_N, state.water.left_robot_cup) == (0.75, 8.5, 11)
    bare = read_scene(people=1, kinds=("STAND", "STAND"), water=False)
    assert (bare.second, bare.traced_object, bare.crank, bare.has_water, bare.has_robot_cup) == (
        -1,
        -1,
        -1,
        False,
        False,
    )


def test_trace_shows_the_scene(tmp_path):
    trace, error = ffi.new("trace_csv_t *"), ffi.new("char[]", 200)
    path = tmp_path / "trace.csv"
    record = ffi.new("tick_record_t *", {"time_ns": 2_345_000_000, "mode": COOPERATING})
    assert lib.trace_csv_open(trace, str(path).encode(), error, 200)
    lib.trace_csv_write(trace, record, read_scene())
    lib.trace_csv_write(trace, record, read_scene(people=1, kinds=(), water=False))
    assert lib.trace_csv_close(trace, str(path).encode(), error, 200)
    names, *rows = csv.reader(path.open())
    assert [len(row) for row in rows] == [len(names)] * 2
    full, bare = (dict(zip(names, row, strict=True)) for row in rows)
    shown = {
        "t_s": 2.345, "person_x_m": 10, "person_qw": 1, "second_x_m": 11, "second_z_m": -0.5, "object_x_m": 21,
        "object_qx": 1, "gripper_opening": 0.75, "force_x_N": 1, "force_y_N": 2, "force_z_N": 3,
        "second_force_N": round(2 * np.sqrt(14), 4), "clearance_person_mm": 21.5, "clearance_self_mm": 500,
        "water_robot": 50, "water_person": 6, "water_spilt": 4, "crank_turns": 2.5,
    }  # fmt: skip
    assert {name: float(full[name]) for name in shown} == shown
    empty = {name for name in names if bare[name] == ""}
    assert {name for name in shown if name.startswith(("second", "object", "water", "crank"))} <= empty
    assert float(bare["person_x_m"]) == 10 and "force_z_N" in empty, "there is no object to hold"
    assert names[:25] == [
        "t_s", "mode", *(f"{who}_{part}" for who in ("target", "hand") for part in
                         ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")),
        *(f"q{i}_rad" for i in range(4)), *(f"dq{i}_command_radps" for i in range(4)), "person_x_m",
    ]  # fmt: skip
