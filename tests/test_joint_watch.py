"""Checks the watch of the joints against drives that are simulated here in double precision: healthy drives of every
lag cause no finding, and each kind of fault is found within its time."""

from __future__ import annotations

import numpy as np
import pytest
from comanip._core import ffi, lib

JOINTS = 4
WRAP = 2**32
ARM = lib.arm_hoap3_right
LAG_MAX_S = ARM.drive_lag_max_s
RANGE_RAD = np.array([[joint.position_min_rad, joint.position_max_rad] for joint in ARM.joints[0:JOINTS]])
MIDDLE_RAD = RANGE_RAD.mean(axis=1)
SPEED_MAX_RADPS, ACCELERATION_MAX_RADPS2 = 4.76, 25.0
DEVIATION_RAD = 10e-3
TICKS_MS = {"fd": 1, "classic": 4}
TIMEOUT_US = 1000 * lib.frame_table[lib.FRAME_JOINT_STATE0].timeout_ms
OK, DEVIATES = lib.JOINT_WATCH_OK, lib.JOINT_WATCH_DEVIATES


class Watched:
    """An arm whose drives follow their commands with a first-order lag, and the watch of its joints.

    lag_s, report_ticks: of all drives. A report is sampled report_ticks (0 or 1) ticks before the check: with 0, it is
    sampled at the end of the last command's tick, and with 1, at its beginning.
    """

    def __init__(self, profile: str = "fd", lag_s: float = 3e-3, report_ticks: int = 1):
        self.tick_ms, self.lag_s, self.report_ticks = TICKS_MS[profile], lag_s, report_ticks
        self.timeout_us = 1000 * (3 if profile == "fd" else 12)
        self.now_us = 0
        self.position_rad, self.speed_radps = MIDDLE_RAD.copy(), np.zeros(JOINTS)
        self.command_radps = np.zeros(JOINTS)
        self.commanded_rad, self.reported_rad = self.position_rad.copy(), self.position_rad.copy()
        self.last_rad = self.position_rad.copy()
        self.mode = lib.DRIVE_MODE_VELOCITY
        self.mode_reported: int | None = None
        self.powered = True
        self.error = lib.DRIVE_ERROR_NONE
        self.answers = True
        self.encoder = lambda position_rad: position_rad
        self.drive = self.follow
        self.watch = ffi.new("joint_watch_t *")
        lib.joint_watch_init(self.watch, ffi.addressof(ARM), self.tick_ms, self.timeout_us)

    def follow(self, command_radps: np.ndarray) -> None:
        """Moves the joints for one tick: the exact solution of lag_s dv/dt = command - v."""
        tick_s = 1e-3 * self.tick_ms
        decay = np.exp(-tick_s / self.lag_s) if self.lag_s > 0 else 0.0
        excess = self.speed_radps - command_radps
        self.position_rad = self.position_rad + command_radps * tick_s + self.lag_s * (1 - decay) * excess
        self.speed_radps = command_radps + decay * excess

    def tick(self, command_radps=None):
        """Runs one tick, and returns the result of its check. command_radps: (4,), None to repeat the last command."""
        self.now_us += 1000 * self.tick_ms
        reported = self.encoder(self.last_rad if self.report_ticks else self.position_rad)
        self.last_rad = self.position_rad.copy()
        self.commanded_rad = self.commanded_rad + 1e-3 * self.tick_ms * self.command_radps
        self.reported_rad = reported
        if self.answers:
            mode = self.mode if self.mode_reported is None else self.mode_reported
            for joint in range(JOINTS):
                state = ffi.new("joint_state_t *", {"error": self.error, "mode": mode})
                state.position_rad = round(1e6 * reported[joint]) * 1e-6
                lib.joint_watch_report(self.watch, joint, state, self.now_us % WRAP)
        result = lib.joint_watch_check(self.watch, self.now_us % WRAP)
        if command_radps is not None:
            self.command_radps = np.round(np.asarray(command_radps, float), 3)
        command = ffi.new("joint_cmd_t *")
        for joint in range(JOINTS):
            command.mode[joint] = self.mode
            command.velocity_radps[joint] = self.command_radps[joint]
        lib.joint_watch_command(self.watch, command, self.powered)
        self.drive(self.command_radps)
        return result

    def deviation_rad(self) -> float:
        """Returns the largest distance from the reported positions to the band, from the watch's own state."""
        worst = 0.0
        for joint in self.watch.joint[0:JOINTS]:
            ahead = joint.ahead_urad
            edges = ahead, ahead + joint.velocity_mradps * self.tick_ms, ahead - LAG_MAX_S * 1e3 * joint.lagging / 64
            worst = max(worst, min(edges), -max(edges))
        return 1e-6 * worst


def wander(rng: np.random.Generator, duration_s: float, tick_ms: int) -> np.ndarray:
    """Returns commands (N, 4) at the arm's full speed and acceleration that change direction at random, and that keep
    the joints within 0.4 rad of the middle of their ranges."""
    tick_s = 1e-3 * tick_ms
    velocity, way, target, rows = np.zeros(JOINTS), np.zeros(JOINTS), np.zeros(JOINTS), []
    for _ in range(round(duration_s / tick_s)):
        turn = rng.random(JOINTS) < tick_s / 0.05
        target = np.where(turn, rng.uniform(-1, 1, JOINTS) * SPEED_MAX_RADPS, target)
        stopping = way + np.sign(velocity) * velocity**2 / (2 * ACCELERATION_MAX_RADPS2)
        target = np.where(np.abs(stopping) > 0.4, -np.sign(stopping) * SPEED_MAX_RADPS, target)
        change = np.clip(target - velocity, -ACCELERATION_MAX_RADPS2 * tick_s, ACCELERATION_MAX_RADPS2 * tick_s)
        velocity = np.round(velocity + change, 3)
        way = way + velocity * tick_s
        rows.append(velocity)
    return np.array(rows)


# ---- healthy drives


@pytest.mark.parametrize("report_ticks", [0, 1])
@pytest.mark.parametrize("lag_ms", [0, 1, 3, 8, 13])
@pytest.mark.parametrize("profile", TICKS_MS)
def test_healthy_drives_cause_no_finding(profile, lag_ms, report_ticks):
    """The slowest drive, whose reports are also late, stays within half of the allowed deviation."""
    arm = Watched(profile, 1e-3 * lag_ms, report_ticks)
    worst = 0.0
    for command in wander(np.random.default_rng(lag_ms), 20.0, arm.tick_ms):
        assert arm.tick(command).finding == OK
        worst = max(worst, arm.deviation_rad())
    late_rad = SPEED_MAX_RADPS * 1e-3 * arm.tick_ms * (lag_ms == 13 and report_ticks)  # a lag above the largest one
    assert worst < max(late_rad, 0.5 * DEVIATION_RAD)


def test_noise_of_the_encoders_causes_no_finding():
    rng, arm = np.random.default_rng(1), Watched()
    arm.encoder = lambda position_rad: position_rad + rng.normal(scale=1e-3, size=JOINTS)
    assert {arm.tick(command).finding for command in wander(rng, 20.0, 1)} == {OK}


def test_a_drive_that_is_slightly_too_fast_at_rest_causes_no_finding():
    """The band follows a drift of 0.4 mrad/s, and no more than 0.5 mrad/s."""
    found = []
    for drift_radps in (0.4e-3, 0.7e-3):
        arm = Watched()
        arm.drive = lambda command, arm=arm, drift=drift_radps: arm.follow(command + drift)
        found.append({arm.tick(np.zeros(JOINTS)).finding for _ in range(100_000)})
    assert found == [{OK}, {OK, DEVIATES}]


@pytest.mark.parametrize("profile", TICKS_MS)
def test_late_ticks_cause_no_deviation(profile):
    """A loop that comes late, or that leaves out up to three ticks, sends its commands late. They last until then."""
    rng, arm = np.random.default_rng(3), Watched(profile)
    step_ms, arm.timeout_us = arm.tick_ms, 2**30
    for command in wander(rng, 20.0, step_ms):
        left_out = int(rng.integers(4)) if rng.random() < 0.01 else 0
        for _ in range(left_out):  # the plant goes on without the firmware
            arm.last_rad = arm.position_rad.copy()
            arm.drive(arm.command_radps)
        arm.now_us += 1000 * step_ms * left_out
        late_us = int(rng.integers(0, 300 * step_ms))
        arm.now_us += late_us
        assert arm.tick(command).finding == OK
        arm.now_us -= late_us


def test_lost_reports_cause_no_deviation():
    rng, arm = np.random.default_rng(2), Watched()
    for command in wander(rng, 10.0, 1):
        arm.answers = arm.now_us - arm.watch.joint[0].received_us > 1000 or rng.random() < 0.5
        assert arm.tick(command).finding == OK


# ---- faults


def time_to_find_ms(arm: Watched, finding: int, most: int = 1000) -> int:
    """Returns the time from the first check at which the commanded and the reported motion differ by more than 10 mrad
    to the check that finds a fault: 0 if it is the same one. A difference before the fault does not count."""
    differs = 0
    for _ in range(most):
        result = arm.tick()
        differs += bool(differs) or np.abs(arm.commanded_rad - arm.reported_rad).max() > DEVIATION_RAD
        if result.finding != OK:
            assert result.finding == finding
            return arm.tick_ms * max(0, differs - 1)
    raise AssertionError(f"not found within {most} ticks")


def in_motion(profile: str, speed_radps: float, joint: int = 0, lag_s: float = 3e-3) -> Watched:
    """Returns an arm, one joint of which moves at a steady speed through the middle of its range."""
    arm = Watched(profile, lag_s)
    command = speed_radps * np.eye(JOINTS)[joint]
    arm.position_rad = arm.position_rad - np.sign(speed_radps) * 0.5 * np.eye(JOINTS)[joint]
    arm.last_rad = arm.commanded_rad = arm.position_rad
    arm.powered = False
    arm.tick(np.zeros(JOINTS))
    arm.powered = True
    for factor in np.linspace(0, 1, 250 // arm.tick_ms + 1):
        assert arm.tick(factor * command).finding == OK
    return arm


def allowed_ms(profile: str, time_ms: int) -> int:
    """Returns a detection time in whole ticks, since faults are looked for once per tick."""
    return -(-time_ms // TICKS_MS[profile]) * TICKS_MS[profile]


@pytest.mark.parametrize("jump_rad", [-0.5, -0.03, -0.011, 0.011, 0.03, 0.5])
@pytest.mark.parametrize("joint", range(JOINTS))
@pytest.mark.parametrize("profile", TICKS_MS)
def test_a_jump_of_an_encoder_is_found_in_the_tick_of_its_report(profile, joint, jump_rad):
    arm = Watched(profile)
    arm.tick(np.zeros(JOINTS))
    arm.tick()
    arm.encoder = lambda position_rad: position_rad + jump_rad * np.eye(JOINTS)[joint]
    assert arm.tick().finding == DEVIATES


@pytest.mark.parametrize("speed_radps", [-4.0, -1.0, 1.0, 4.0])
@pytest.mark.parametrize("jump_rad", [-0.1, 0.1])
@pytest.mark.parametrize("profile", TICKS_MS)
def test_a_jump_in_motion_is_found_in_the_tick_of_its_report(profile, jump_rad, speed_radps):
    arm = in_motion(profile, speed_radps)
    arm.encoder = lambda position_rad: position_rad + jump_rad * np.eye(JOINTS)[0]
    assert arm.tick().finding == DEVIATES


@pytest.mark.parametrize("profile", TICKS_MS)
def test_a_flipped_sign_is_found_in_the_tick_of_its_report(profile):
    arm = in_motion(profile, 1.0)
    arm.encoder = lambda position_rad: -position_rad
    assert arm.tick().finding in (DEVIATES, lib.JOINT_WATCH_OUT_OF_RANGE)


@pytest.mark.parametrize("speed_radps", [-4.0, -1.0, -0.2, 0.2, 1.0, 4.0])
@pytest.mark.parametrize("kind", ["stuck encoder", "drive that stands still"])
@pytest.mark.parametrize("profile", TICKS_MS)
def test_a_joint_without_motion_is_found_within_20_ms(profile, kind, speed_radps):
    arm = in_motion(profile, speed_radps)
    reported = arm.last_rad.copy()
    if kind == "stuck encoder":
        arm.encoder = lambda position_rad: reported
    else:
        arm.drive = lambda command: None
    assert time_to_find_ms(arm, DEVIATES) <= allowed_ms(profile, 20)


@pytest.mark.parametrize("speed_radps", [-4.0, -1.0, -0.2, 0.2, 1.0, 4.0])
@pytest.mark.parametrize("profile", TICKS_MS)
def test_an_inverted_drive_is_found_within_30_ms(profile, speed_radps):
    arm = in_motion(profile, speed_radps)
    arm.drive = lambda command: arm.follow(-command)
    assert time_to_find_ms(arm, DEVIATES) <= allowed_ms(profile, 30)


@pytest.mark.parametrize("extra_radps", [-4.0, -1.0, -0.2, 0.2, 1.0, 4.0])
@pytest.mark.parametrize("speed_radps", [0.0, 0.5])
@pytest.mark.parametrize("profile", TICKS_MS)
def test_a_drive_that_runs_away_is_found_within_30_ms(profile, speed_radps, extra_radps):
    """If the drive becomes slower, the position must first leave the band, as wide as the way in drive_lag_max_s."""
    arm = in_motion(profile, speed_radps)
    arm.drive = lambda command: arm.follow(command + extra_radps * np.eye(JOINTS)[0])
    across_ms = 1e3 * LAG_MAX_S * max(0.0, -speed_radps / extra_radps)
    assert time_to_find_ms(arm, DEVIATES) <= allowed_ms(profile, 30 + round(across_ms))


@pytest.mark.parametrize("profile", TICKS_MS)
def test_a_wrong_mode_is_found_after_20_ms(profile):
    arm = Watched(profile)
    for _ in range(10):
        assert arm.tick(np.zeros(JOINTS)).finding == OK
    arm.mode_reported = lib.DRIVE_MODE_BRAKE
    found = [arm.tick().finding for _ in range(20 // arm.tick_ms + 1)]
    assert found == [OK] * (20 // arm.tick_ms) + [lib.JOINT_WATCH_WRONG_MODE]
    arm.mode_reported = lib.DRIVE_MODE_VELOCITY
    assert arm.tick().finding == OK


@pytest.mark.parametrize("joint", range(JOINTS))
@pytest.mark.parametrize("side", [0, 1])
def test_a_position_out_of_range_is_found_while_the_drives_are_powered(joint, side):
    outwards = (2 * side - 1) * np.eye(JOINTS)[joint]
    for beyond_rad, finding in ((9.9e-3, OK), (10.1e-3, lib.JOINT_WATCH_OUT_OF_RANGE)):
        arm = Watched()
        arm.position_rad = np.where(outwards != 0, RANGE_RAD[joint, side], MIDDLE_RAD) + beyond_rad * outwards
        arm.last_rad, arm.powered = arm.position_rad, False
        assert [arm.tick(np.zeros(JOINTS)).finding for _ in range(3)] == [OK] * 3
        arm.powered = True
        arm.tick()
        result = arm.tick()
        assert (result.finding, result.in_range) == (finding, finding == OK)


@pytest.mark.parametrize(
    "error", [lib.DRIVE_ERROR_COMMAND_TIMEOUT, lib.DRIVE_ERROR_OVER_TEMPERATURE, lib.DRIVE_ERROR_ENCODER]
)
@pytest.mark.parametrize("powered", [False, True])
def test_an_error_of_a_drive_is_found_at_once(error, powered):
    arm = Watched()
    arm.powered = powered
    arm.tick()
    assert arm.tick().finding == OK
    arm.error = error
    assert arm.tick().finding == lib.JOINT_WATCH_ERROR


def test_a_motion_without_power_is_no_finding():
    """A person may move the arm by hand."""
    arm = Watched()
    arm.powered, arm.mode = False, lib.DRIVE_MODE_BRAKE
    arm.drive = lambda command: setattr(arm, "position_rad", arm.position_rad + 1e-3)
    assert {arm.tick().finding for _ in range(400)} == {OK}
    arm.drive, arm.powered, arm.mode = arm.follow, True, lib.DRIVE_MODE_VELOCITY
    assert {arm.tick().finding for _ in range(400)} == {OK}, "and then it is started where it is"


def test_silence_comes_before_error_range_deviation_and_mode():
    arm = Watched()
    arm.tick()
    found = []
    for change in (
        {"mode_reported": lib.DRIVE_MODE_BRAKE}, {"encoder": lambda position_rad: position_rad + 0.02},
        {"encoder": lambda position_rad: position_rad + 4.0}, {"error": lib.DRIVE_ERROR_ENCODER}, {"answers": False},
    ):  # fmt: skip
        vars(arm).update(change)
        found.append([arm.tick().finding for _ in range(30)][-1])
    assert found == [
        lib.JOINT_WATCH_WRONG_MODE, DEVIATES, lib.JOINT_WATCH_OUT_OF_RANGE, lib.JOINT_WATCH_ERROR,
        lib.JOINT_WATCH_SILENT,
    ]  # fmt: skip


# ---- silence


def watch_at(times_us) -> object:
    """Returns a watch after one report of each joint, at these times."""
    watch = ffi.new("joint_watch_t *")
    lib.joint_watch_init(watch, ffi.addressof(ARM), 1, TIMEOUT_US)
    for joint, time_us in enumerate(times_us):
        lib.joint_watch_report(watch, joint, ffi.new("joint_state_t *"), time_us % WRAP)
    return watch


@pytest.mark.parametrize("zero", [0, WRAP - 1000, WRAP - TIMEOUT_US])
@pytest.mark.parametrize("oldest", range(JOINTS))
def test_a_report_counts_until_the_timeout(zero, oldest):
    watch = watch_at([zero + (0 if joint == oldest else 500) for joint in range(JOINTS)])
    assert lib.joint_watch_check(watch, (zero + TIMEOUT_US) % WRAP).finding == OK
    assert lib.joint_watch_check(watch, (zero + TIMEOUT_US + 1) % WRAP).finding == lib.JOINT_WATCH_SILENT


def test_a_joint_that_never_reported_is_silent():
    assert lib.joint_watch_check(watch_at([0, 0, 0]), 0).finding == lib.JOINT_WATCH_SILENT
    assert lib.joint_watch_check(watch_at([0] * JOINTS), 0).finding == OK


def test_a_report_does_not_become_fresh_again_when_the_clock_wraps():
    watch = watch_at([0] * JOINTS)
    assert lib.joint_watch_check(watch, TIMEOUT_US + 1).finding == lib.JOINT_WATCH_SILENT
    assert lib.joint_watch_check(watch, 0).finding == lib.JOINT_WATCH_SILENT


# ---- at rest


@pytest.mark.parametrize("profile", TICKS_MS)
def test_a_joint_is_at_rest_after_50_ms_within_1_mrad(profile):
    arm = Watched(profile)
    arm.powered = False
    assert not arm.tick(np.zeros(JOINTS)).at_rest
    ticks = int(np.ceil(50 / arm.tick_ms))
    assert [arm.tick().at_rest for _ in range(ticks)] == [False] * (ticks - 1) + [True]
    arm.position_rad = arm.position_rad + 0.9e-3
    assert all(arm.tick().at_rest for _ in range(100))
    arm.position_rad = arm.position_rad + 0.2e-3 * np.eye(JOINTS)[2]
    seen = [arm.tick().at_rest for _ in range(ticks + 2)]
    assert not all(seen[:ticks]) and seen[-1]
    arm.answers = False
    arm.now_us += arm.timeout_us
    assert not arm.tick().at_rest


def test_a_slow_joint_is_not_at_rest():
    arm = Watched()
    arm.powered = False
    arm.drive = lambda command: setattr(arm, "position_rad", arm.position_rad + 30e-6)  # 30 mrad/s
    assert not any(arm.tick().at_rest for _ in range(500))
