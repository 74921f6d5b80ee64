"""Runs the whole controller with faulty encoders and drives. A fault that shows ends in mode fault with its reason, and
until then the arm's true hand stays near that of an arm without the fault."""

from __future__ import annotations

import copy

import numpy as np
import oracle
import pytest
from comanip._core import lib
from controller_bench import JOINTS, Bench

ACCELERATION_RADPS2, JERK_RADPS3, TICK_S = 25.0, 1e4, 1e-3
HIDDEN_HAND_M = 0.030  # the most that a fault may move the hand before it is found
UNFOUND_TICKS = 3000
RANGE_RAD = np.array([[j.position_min_rad, j.position_max_rad] for j in lib.arm_hoap3_right.joints[0:JOINTS]])
SPEEDS = {"at rest": 0.0, "slowly": 0.1, "fast": 1.0}  # speed of the person's hand in m/s
HAND_M, SWING_M = np.array([0.4, 0.2, 0.1]), 0.1


class Arm(Bench):
    """A bench, the hand of which swings with the given peak speed. The drives have a lag of 3 ms."""

    def __init__(self, speed_mps: float):
        super().__init__(prediction=True)
        self.rate_radps = speed_mps / SWING_M
        self.speed_radps = np.zeros(JOINTS)
        self.drive = self.follow
        self.until_ready().start(lib.TASK_TELEOP)

    def follow(self, position_rad: np.ndarray, command_radps: np.ndarray) -> np.ndarray:
        self.speed_radps = self.speed_radps + (command_radps - self.speed_radps) * (1 - np.exp(-TICK_S / 3e-3))
        return position_rad + self.speed_radps * TICK_S

    def tick(self, count: int = 1) -> None:
        for _ in range(count):
            swing_m = SWING_M * np.sin(self.rate_radps * self.now_us * 1e-6) if self.ticks > 100 else 0.0
            self.hand = oracle.pose(self.hand[:4], HAND_M + swing_m * np.array([1.0, 0.5, 0.5]) / np.sqrt(1.5))
            super().tick()


def stick(arm: Arm, joint: int) -> None:
    stuck_rad = arm.position_rad[joint]
    arm.encoder = lambda position_rad: np.where(np.arange(JOINTS) == joint, stuck_rad, position_rad)


def flip(arm: Arm, joint: int) -> None:
    """From now on, the encoder counts backwards."""
    now_rad = arm.position_rad[joint]
    arm.encoder = lambda position_rad: np.where(np.arange(JOINTS) == joint, 2 * now_rad - position_rad, position_rad)


def negate(arm: Arm, joint: int) -> None:
    arm.encoder = lambda position_rad: np.where(np.arange(JOINTS) == joint, -position_rad, position_rad)


def jump(size_rad: float):
    def fail(arm: Arm, joint: int) -> None:
        arm.encoder = lambda position_rad: position_rad + size_rad * (np.arange(JOINTS) == joint)

    return fail


def drift(arm: Arm, joint: int) -> None:
    """The encoder's reading creeps away by 20 mrad/s."""
    begin_us = arm.now_us
    arm.encoder = lambda position_rad: (
        position_rad + 20e-3 * (arm.now_us - begin_us) * 1e-6 * (np.arange(JOINTS) == joint)
    )


def stand(arm: Arm, joint: int) -> None:
    arm.drive = lambda position_rad, command_radps: np.where(
        np.arange(JOINTS) == joint, position_rad, arm.follow(position_rad, command_radps)
    )


def run_away(speed_radps: float):
    def fail(arm: Arm, joint: int) -> None:
        arm.drive = lambda position_rad, command_radps: arm.follow(
            position_rad, np.where(np.arange(JOINTS) == joint, speed_radps, command_radps)
        )

    return fail


def invert(arm: Arm, joint: int) -> None:
    arm.drive = lambda position_rad, command_radps: arm.follow(
        position_rad, np.where(np.arange(JOINTS) == joint, -command_radps, command_radps)
    )


def brake(arm: Arm, joint: int) -> None:
    """The drive engages its brake by itself, and says so."""
    stand(arm, joint)
    arm.mode_reported = lib.DRIVE_MODE_BRAKE


ENCODER_FAULTS = {"stuck": stick, "backwards": flip, "jump +0.05": jump(0.05), "jump -0.5": jump(-0.5), "drift": drift}
DRIVE_FAULTS = {
    "stands still": stand, "runs away at 0.2": run_away(0.2), "runs away at -3": run_away(-3.0), "inverted": invert,
}  # fmt: skip
DEVIATION = lib.REASON_JOINT_DEVIATES, lib.REASON_JOINT_OUT_OF_RANGE


def hand_m(arm: Arm) -> np.ndarray:
    return oracle.translation(arm.robot)


def run_with_fault(speed: str, fail, joint: int, ticks: int = UNFOUND_TICKS) -> tuple[Arm, float]:
    """Returns the arm in the tick in which the fault is found, or after `ticks`, and the largest distance of its true
    hand from that of an arm without the fault."""
    arm, healthy = Arm(SPEEDS[speed]), Arm(SPEEDS[speed])
    arm.tick(700), healthy.tick(700)
    assert arm.mode == healthy.mode == lib.MODE_COOPERATING
    assert (arm.position_rad == healthy.position_rad).all()
    fail(arm, joint)
    worst_m = 0.0
    for _ in range(ticks):
        arm.tick(), healthy.tick()
        worst_m = max(worst_m, float(np.linalg.norm(hand_m(arm) - hand_m(healthy))))
        if arm.mode == lib.MODE_FAULT:
            break
    assert healthy.mode == lib.MODE_COOPERATING
    return arm, worst_m


@pytest.mark.parametrize("joint", range(JOINTS))
@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("fault", [*ENCODER_FAULTS, *DRIVE_FAULTS])
def test_what_a_fault_hides_is_bounded(fault, speed, joint):
    """A fault is found before the hand is 30 mm away, or never moves it as far."""
    arm, worst_m = run_with_fault(speed, (ENCODER_FAULTS | DRIVE_FAULTS)[fault], joint)
    assert worst_m < HIDDEN_HAND_M
    if arm.mode == lib.MODE_FAULT:
        assert arm.reason in DEVIATION
    else:
        assert fault in ("stuck", "backwards", "stands still", "inverted")
        assert speed != "fast" or joint == 2, "only the shoulder's torsion is hardly used by this motion"


@pytest.mark.parametrize("fault", ["jump +0.05", "jump -0.5", "negated", "runs away at -3"])
@pytest.mark.parametrize("speed", SPEEDS)
def test_a_fault_stops_the_arm_and_stays_until_it_is_acknowledged_at_standstill(fault, speed):
    fail = (ENCODER_FAULTS | DRIVE_FAULTS | {"negated": negate})[fault]
    arm, _ = run_with_fault(speed, fail, joint=3)
    assert arm.mode == lib.MODE_FAULT and arm.reason in DEVIATION
    speed_radps = np.abs(arm.velocity_radps)
    stop_s = speed_radps.max() / ACCELERATION_RADPS2 + 2.5 * ACCELERATION_RADPS2 / JERK_RADPS3 + 2 * TICK_S
    for _ in range(int(np.ceil(stop_s / TICK_S))):
        assert arm.command(lib.COMMAND_ACKNOWLEDGE) in (lib.RESULT_FAULT_PRESENT, lib.RESULT_NOT_AT_REST)
    assert (arm.velocity_radps == 0).all()
    arm.drive = lambda position_rad, command_radps: position_rad  # the brakes hold
    arm.position_rad = np.clip(arm.position_rad, RANGE_RAD[:, 0], RANGE_RAD[:, 1])  # moved back by hand
    arm.encoder = lambda position_rad: position_rad
    arm.tick(100)
    assert not arm.outbox.enable_drives
    assert arm.command(lib.COMMAND_START) == lib.RESULT_WRONG_MODE
    assert arm.command(lib.COMMAND_STOP) == lib.RESULT_NOT_ACKNOWLEDGED
    assert arm.mode == lib.MODE_FAULT and arm.reason in DEVIATION
    assert arm.command(lib.COMMAND_ACKNOWLEDGE) == lib.RESULT_ACCEPTED
    assert (arm.mode, arm.reason) == (lib.MODE_IDLE, lib.REASON_FAULT_CLEARED)
    arm.tick(2)
    arm.speed_radps, arm.drive = np.zeros(JOINTS), arm.follow
    assert arm.mode == lib.MODE_READY and arm.command(lib.COMMAND_START) == lib.RESULT_ACCEPTED
    arm.tick(500)
    assert arm.mode == lib.MODE_COOPERATING


def test_a_runaway_drive_has_power_until_the_commanded_stop_is_over():
    """The other joints brake within their limits meanwhile. The drives lose power one tick after the brakes engage."""
    arm, _ = run_with_fault("fast", run_away(4.76), joint=0)
    speed_radps, begin_rad = np.abs(arm.velocity_radps).max(), arm.position_rad[0]
    stop_s = speed_radps / ACCELERATION_RADPS2 + 2.5 * ACCELERATION_RADPS2 / JERK_RADPS3 + 2 * TICK_S
    powered_ticks = 0
    while arm.outbox.enable_drives:
        arm.tick()
        powered_ticks += 1
    assert 0 < powered_ticks * TICK_S <= stop_s + 2 * TICK_S
    assert 0 < arm.position_rad[0] - begin_rad <= 4.76 * powered_ticks * TICK_S + 1e-9


def test_the_first_command_after_the_detection_brakes():
    """The check and the command are of the same tick."""
    arm, _ = run_with_fault("fast", jump(0.05), joint=3)
    found_radps = arm.velocity_radps
    last = copy.copy(found_radps)
    for _ in range(3):
        arm.tick()
        assert (np.abs(arm.velocity_radps) <= np.abs(last)).all()
        last = arm.velocity_radps
    assert (np.abs(last) < np.abs(found_radps)).any()


def test_a_drive_that_reports_its_brake_is_found_within_20_ms():
    arm = Arm(SPEEDS["slowly"])
    arm.tick(700)
    brake(arm, joint=2)
    arm.tick(20)
    assert arm.mode == lib.MODE_COOPERATING
    arm.tick(2)
    assert (arm.mode, arm.reason) == (lib.MODE_FAULT, lib.REASON_DRIVE_MODE)


@pytest.mark.parametrize("fault", [stick, jump(0.3), run_away(1.0)])
def test_a_fault_while_stopping_stays_a_fault(fault):
    arm = Arm(SPEEDS["fast"])
    arm.tick(700)
    assert np.abs(arm.velocity_radps).max() > 0.5
    assert arm.command(lib.COMMAND_STOP) == lib.RESULT_ACCEPTED
    assert arm.mode == lib.MODE_READY
    fault(arm, int(np.argmax(np.abs(arm.velocity_radps))))
    arm.tick(200)
    assert arm.mode == lib.MODE_FAULT and arm.reason in DEVIATION


@pytest.mark.parametrize("joint", range(JOINTS))
def test_a_start_out_of_range_is_refused_by_name(joint):
    limit_rad = lib.arm_hoap3_right.joints[joint].position_max_rad
    bench = Bench()
    bench.position_rad[joint] = limit_rad + np.radians(10)
    bench.until_ready()
    assert bench.command(lib.COMMAND_START) == lib.RESULT_JOINT_OUT_OF_RANGE
    bench.position_rad[joint] = limit_rad
    bench.tick(100)
    assert bench.command(lib.COMMAND_START) == lib.RESULT_ACCEPTED


def test_a_start_of_a_moving_arm_is_refused_by_name():
    """The person moves the arm by hand, or it still brakes."""
    bench = Bench().until_ready()
    moved_rad = bench.position_rad
    bench.encoder = lambda position_rad: moved_rad + 0.1e-3 * bench.ticks
    bench.tick(30)
    assert bench.command(lib.COMMAND_START) == lib.RESULT_NOT_AT_REST
    bench.position_rad = bench.encoder(moved_rad)
    bench.encoder = lambda position_rad: position_rad
    bench.tick(60)
    assert bench.command(lib.COMMAND_START) == lib.RESULT_ACCEPTED
    bench.move_hand([0.05, 0, 0])
    bench.tick(30)
    assert bench.command(lib.COMMAND_STOP) == lib.RESULT_ACCEPTED
    assert bench.mode == lib.MODE_READY and bench.command(lib.COMMAND_START) == lib.RESULT_NOT_AT_REST
