"""Tests posture_change through controller_step(). In a dead end, joints at their limits keep the arm from a target that
another posture reaches."""

from __future__ import annotations

import numpy as np
import oracle
import pytest
from comanip._core import ffi, lib
from controller_bench import FRAME_ID, TICK_US, Bench

TICK_S = TICK_US * 1e-6
MOVE_S = 1.0
# joint angles at the start [deg] and displacement of the hand [m] in torso axes, found by random search
DEAD_ENDS = [
    ((81, -90, 20, -79), (-0.04, 0.11, 0.08)),
    ((74, -95, 1, -76), (0.08, 0.18, -0.07)),
    ((22, -73, 42, -111), (-0.04, 0.02, 0.04)),
]
JOINT_RADPS, HAND_MPS = 0.25 * 4.76, 0.25


def started(start_deg, **changes) -> Bench:
    bench = Bench(position_deg=start_deg, prediction=True).until_ready()
    for name, value in ({"posture_change": 1} | changes).items():
        assert bench.write(getattr(lib, f"PARAMETER_{name.upper()}"), value) == lib.RESULT_ACCEPTED
    return bench.start(lib.TASK_TELEOP)


def phase(bench: Bench) -> int:
    return bench.controller.posture_change.phase


def position_m(bench: Bench) -> np.ndarray:
    return oracle.translation(bench.robot)


def error_m(bench: Bench) -> float:
    return np.linalg.norm(oracle.translation(bench.target) - position_m(bench))


def reported(bench: Bench) -> bool | None:
    """Returns changes_posture of the FirmwareStatus sent in this tick, or None if none was sent."""
    for number, data in bench.sent:
        if number == FRAME_ID["FIRMWARE_STATUS"]:
            frame = ffi.new("can_frame_t *", {"length": len(data)})
            ffi.memmove(frame.data, data, len(data))
            message = ffi.new("firmware_status_t *")
            lib.firmware_status_unpack(frame, message)
            return message.changes_posture
    return None


def carry(bench: Bench, way_m, duration_s: float = MOVE_S) -> list[int]:
    """Moves the hand by `way_m` along a minimum-jerk profile. Returns the phase of the posture change in each tick."""
    s = np.arange(1, round(duration_s / TICK_S) + 1) * TICK_S / duration_s
    steps = np.diff(s**3 * (10 - 15 * s + 6 * s**2), prepend=0.0)
    phases = []
    for step in steps:
        bench.move_hand(step * np.asarray(way_m))
        bench.tick()
        phases.append(phase(bench))
    return phases


def wait(bench: Bench, for_s: float) -> list[int]:
    return carry(bench, np.zeros(3), for_s)


def until(bench: Bench, expected: int, at_most_s: float = 8.0) -> Bench:
    for _ in range(round(at_most_s / TICK_S)):
        if phase(bench) == expected:
            return bench
        bench.tick()
    raise AssertionError(f"phase {phase(bench)} after {at_most_s} s")


def on_the_way(dead_end=DEAD_ENDS[0], **changes) -> Bench:
    bench = started(dead_end[0], **changes)
    carry(bench, dead_end[1])
    until(bench, lib.POSTURE_CHANGING).tick(500)
    assert phase(bench) == lib.POSTURE_CHANGING
    return bench


def searches(phases: list[int]) -> int:
    return int(np.count_nonzero(np.diff(np.asarray(phases) == lib.POSTURE_SEARCHED, prepend=False, append=False)) / 2)


def at_rest(bench: Bench) -> bool:
    return np.abs(bench.velocity_radps).max() < 0.01


# ---- leaving a dead end


@pytest.mark.parametrize("dead_end", DEAD_ENDS)
def test_a_dead_end_is_left(dead_end):
    """The arm leaves a dead end within its speed limits, reporting the posture change on the bus, and comes
    to rest."""
    bench = started(dead_end[0])
    carry(bench, dead_end[1])
    fastest_radps, fastest_mps, reported_when = 0.0, 0.0, set()
    until(bench, lib.POSTURE_SEARCHED)
    phases, last_m = [], position_m(bench)
    while len(phases) < 8000 and phases[-300:] != 300 * [lib.POSTURE_CHANGED]:
        bench.tick()
        phases.append(phase(bench))
        if phases[-1] == lib.POSTURE_CHANGING:
            fastest_radps = max(fastest_radps, np.abs(bench.velocity_radps).max())
            fastest_mps = max(fastest_mps, np.linalg.norm(position_m(bench) - last_m) / TICK_S)
            last_m = position_m(bench)
        if reported(bench) is not None:
            reported_when.add((phases[-1] == lib.POSTURE_CHANGING, reported(bench)))
    assert reported_when == {(False, False), (True, True)}
    assert 0.5 * JOINT_RADPS < fastest_radps <= JOINT_RADPS + 1e-3
    assert fastest_mps < 1.03 * HAND_MPS  # may slightly exceed the limit, because the jerk limit makes the joints lag
    assert searches(phases) == 1 and phases[-1] == lib.POSTURE_CHANGED
    assert error_m(bench) < 1e-3
    assert (bench.velocity_radps == 0).all()


@pytest.mark.parametrize("dead_end", DEAD_ENDS)
def test_one_parameter_switches_it_off(dead_end):
    bench = started(dead_end[0], posture_change=0)
    assert set(carry(bench, dead_end[1]) + wait(bench, 1.5)) == {lib.POSTURE_WATCHED}
    assert error_m(bench) > 0.02


def test_the_end_effectors_speed_limit_applies_where_it_binds():
    """While the stretched arm swings round, the limit on joint speeds alone would let the end effector move at 0.3 m/s.
    Therefore the end effector's own limit applies."""
    bench = started((128, -54, -68, -99))
    carry(bench, (-0.04, -0.16, 0.11))
    until(bench, lib.POSTURE_CHANGING)
    fastest_mps = 0.0
    while phase(bench) == lib.POSTURE_CHANGING:
        before_m = position_m(bench)
        bench.tick()
        fastest_mps = max(fastest_mps, np.linalg.norm(position_m(bench) - before_m) / TICK_S)
    assert 0.95 * HAND_MPS < fastest_mps < 1.03 * HAND_MPS


def test_a_lower_speed_limit_applies_too():
    bench = on_the_way(speed_fraction=0.1)
    assert 0.4 < np.abs(bench.velocity_radps).max() <= 0.1 * 4.76 + 1e-3


# ---- after the change


def arrived() -> Bench:
    bench = until(on_the_way(), lib.POSTURE_CHANGED)
    bench.tick(100)
    return bench


def test_afterwards_the_hand_is_followed():
    bench = arrived()
    before_m = position_m(bench)
    carry(bench, [0, 0.02, 0.0], 0.5)
    bench.tick(500)
    assert phase(bench) != lib.POSTURE_CHANGED
    assert position_m(bench) - before_m == pytest.approx([0, 0.02, 0], abs=1.5e-3)


def test_an_arm_that_is_pushed_away_returns():
    """A push that moves a joint by more than 10 mrad is a fault."""
    bench = arrived()
    bench.position_rad = bench.position_rad + [9e-3, 9e-3, -9e-3, 9e-3]
    assert error_m(bench) > 1.5e-3
    bench.tick(1000)
    assert error_m(bench) < 1e-3 and at_rest(bench)
    bench.position_rad = bench.position_rad + [0.05, 0.02, -0.03, 0.04]
    bench.tick()
    assert (bench.mode, bench.reason) == (lib.MODE_FAULT, lib.REASON_JOINT_DEVIATES)


# ---- abandoning a change


def test_abandoned_when_the_target_moves_on():
    bench = on_the_way()
    phases = carry(bench, [0, 0, -0.03], 0.3)
    assert phases[0] == lib.POSTURE_CHANGING and phases[-1] == lib.POSTURE_WATCHED
    before = phases.index(lib.POSTURE_WATCHED)
    assert before > 100, "the target must have moved by 20 of the 30 mm"


def test_not_abandoned_while_the_target_stays_near():
    bench = on_the_way()
    assert set(carry(bench, [0, 0, -0.015], 0.3)) == {lib.POSTURE_CHANGING}
    until(bench, lib.POSTURE_LEFT).tick(1000)  # the control law covers the remaining distance
    assert error_m(bench) < 1e-3


@pytest.mark.parametrize("command", ["STOP", "CLUTCH", "LATCH"])
def test_abandoned_by_a_command(command):
    bench = on_the_way()
    assert bench.command(getattr(lib, f"COMMAND_{command}")) == lib.RESULT_ACCEPTED
    assert phase(bench) == lib.POSTURE_WATCHED
    assert lib.POSTURE_CHANGING not in wait(bench, 0.4)


def test_abandoned_by_a_new_task():
    bench = on_the_way()
    assert bench.command(lib.COMMAND_SELECT, lib.TASK_MIRROR) == lib.RESULT_ACCEPTED
    assert phase(bench) == lib.POSTURE_WATCHED


def test_abandoned_in_hold():
    bench = on_the_way()
    bench.hand = None
    bench.tick(200)
    assert bench.mode == lib.MODE_HOLD and phase(bench) == lib.POSTURE_WATCHED
    assert (bench.velocity_radps == 0).all()


# ---- no posture change


def test_not_when_latched():
    start_deg, way_m = DEAD_ENDS[0]
    bench = started(start_deg)
    assert bench.command(lib.COMMAND_LATCH) == lib.RESULT_ACCEPTED
    assert set(carry(bench, way_m) + wait(bench, 2.0)) == {lib.POSTURE_WATCHED}
    assert error_m(bench) > 0.02


def test_not_without_prediction():
    bench = Bench(position_deg=DEAD_ENDS[0][0], prediction=False).until_ready().start(lib.TASK_TELEOP)
    assert set(carry(bench, DEAD_ENDS[0][1]) + wait(bench, 2.0)) == {lib.POSTURE_WATCHED}
    assert error_m(bench) > 0.02


def test_not_at_a_limit_that_does_not_block_the_target():
    bench = started((90, -5, 0, -113.9))
    assert set(carry(bench, [0.03, 0, 0]) + wait(bench, 2.0)) == {lib.POSTURE_WATCHED}
    assert error_m(bench) < 1e-3


def test_not_when_stretched_towards_a_target_out_of_reach():
    bench = started((60, -40, 0, -30))
    assert set(carry(bench, [0.25, -0.02, 0.02]) + wait(bench, 2.0)) <= {
        lib.POSTURE_WATCHED,
        lib.POSTURE_SEARCHED,
        lib.POSTURE_LEFT,
    }
    assert error_m(bench) > 0.05 and at_rest(bench)


def test_out_of_reach_one_search_and_the_arm_stays():
    """If no posture reaches the target, one search is made and the arm stays where it is. A hand that trembles or moves
    to and fro starts no new search, but a move of 20 mm does."""
    bench = started((90, -5, 0, -90))
    phases = carry(bench, [0, 0.5, 0.3]) + wait(bench, 2.0)
    assert searches(phases) == 1 and phases[-1] == lib.POSTURE_LEFT and lib.POSTURE_CHANGING not in phases
    more = [
        p
        for _ in range(3)
        for way in ([0.015, 0, 0], [-0.015, 0, 0])
        for p in carry(bench, way, 0.6) + wait(bench, 0.6)
    ]
    assert set(more) == {lib.POSTURE_LEFT}
    again = carry(bench, [0, 0.025, 0], 0.6) + wait(bench, 2.0)
    assert searches(again) == 1 and again[-1] == lib.POSTURE_LEFT
    assert at_rest(bench)


def test_not_while_the_hand_moves():
    """While the hand moves at 25 mm/s, no posture change starts, although the target is out of reach and some joints
    are at their limits."""
    bench = started((90, -5, 0, -90))
    carry(bench, [0, 0.5, 0.3])
    for _ in range(1500):
        bench.move_hand([0, 25e-3 * TICK_S, 0])
        bench.tick()
        assert phase(bench) == lib.POSTURE_WATCHED
