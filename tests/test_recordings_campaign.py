"""Every recorded hand motion runs through the simulator, and the bus traffic is checked in numpy. At raw resolution,
the robot stays within the manual's limits. It enters the mode hold in time at each gap in the recording, and at no
other moment. All numbers are finite, and a second run repeats the first byte for byte."""

from __future__ import annotations

import filecmp
import io
import re
from dataclasses import dataclass
from pathlib import Path

import bus_log
import numpy as np
import pytest
from hoap3 import PULSES_PER_RAD, STOPS_DEG
from simulation import REPOSITORY, SCENARIOS, Run, modes, run

RECORDINGS = REPOSITORY.parent / "shared" / "data" / "hand_motion"
JOINTS = 4

RANGE_RAD = np.radians(STOPS_DEG + [1.0, -1.0])  # one degree inside the stops given in the manual
VELOCITY_MAX_RAW = 4760  # mrad/s
VELOCITY_STEP_RAW = 25  # 25 rad/s^2 over a tick of 1 ms
JERK_STEP_RAW = 10  # 10,000 rad/s^3: allowed difference of two successive velocity steps
# how far the measured position may exceed the usable range: a fortieth of the distance from there to the stop
OVERSHOOT_RAD = 5 / PULSES_PER_RAD

MOTION_START_S = 2.0
LATENCY_S = 0.004
PERIOD_S = 0.004  # period of the tracker's poses on the bus
STALE_S = 2.5 * PERIOD_S
# A pose takes up to 0.6 ms on the bus, including the frames before it. A tick reads it up to 1 ms later. The mode is
# reported every second tick, 0.1 ms after the tick.
REACTION_S = 0.004


def campaign() -> list:
    files = sorted(path for path in RECORDINGS.glob("*.csv") if not path.stem.endswith("_wrench"))
    if not files:
        reason = f"no recordings in {RECORDINGS}: the folder shared/ is not beside the repository"
        return [pytest.param("teleop", None, id="no-recordings", marks=pytest.mark.skip(reason=reason))]
    runs = [("teleop", path) for path in files]
    runs += [("pour", path) for path in files if path.stem.startswith("kul_")]
    return [pytest.param(scenario, path, id=f"{scenario}-{path.stem}") for scenario, path in runs]


# ---- limits at the bus


def raw_array(frames: bus_log.Frames, pattern: str) -> np.ndarray:
    return np.stack([frames.raw(pattern.format(i)) for i in range(JOINTS)], axis=1)


def measured_positions_rad(frames: dict) -> np.ndarray:
    states = [frames[f"JointState{i}"]["position_rad"] for i in range(JOINTS)]
    return np.stack([state[: min(map(len, states))] for state in states], axis=1)


def assert_limits(frames: dict) -> None:
    commands = frames["JointCmd"]
    ticks = np.diff(commands.t_s)
    assert np.all(np.abs(ticks - 1e-3) < 3e-4), f"a tick without JointCmd at {commands.t_s[np.argmax(ticks)]} s"

    position = raw_array(commands, "position_{}_rad")
    lowest, highest = np.ceil(RANGE_RAD[:, 0] * 1e6), np.floor(RANGE_RAD[:, 1] * 1e6)
    assert np.all(position >= lowest) and np.all(position <= highest), (position.min(axis=0), position.max(axis=0))

    velocity = raw_array(commands, "velocity_{}_radps")
    assert np.abs(velocity).max() <= VELOCITY_MAX_RAW
    steps = np.diff(velocity, axis=0, prepend=0)
    assert np.abs(steps).max() <= VELOCITY_STEP_RAW
    assert np.abs(np.diff(steps, axis=0, prepend=0)).max() <= JERK_STEP_RAW

    drive_mode = raw_array(commands, "mode_{}")
    assert set(np.unique(drive_mode)) <= {0, 1}
    assert not np.any(velocity[drive_mode == 0]), "a brake engages on a moving joint"
    for joint in range(JOINTS, 8):
        for signal in ("mode_{}", "velocity_{}_radps", "torque_{}_Nm"):
            assert not np.any(commands.raw(signal.format(joint))), f"joint {joint}, which does not exist on this arm"

    measured = measured_positions_rad(frames)
    assert np.all(measured > RANGE_RAD[:, 0] - OVERSHOOT_RAD) and np.all(measured < RANGE_RAD[:, 1] + OVERSHOOT_RAD)


# ---- gaps and modes


def bus_validity(recording: Path, measured_s: np.ndarray, logged: np.ndarray) -> np.ndarray:
    """Returns which bus samples must carry a pose. At the edges of a gap, where rounding decides, returns the logged
    validity."""
    t_s = np.loadtxt(recording, delimiter=",", skiprows=1, usecols=0)
    t_s -= t_s[0]
    interval_s = np.diff(t_s)
    starts = np.flatnonzero(interval_s > 1.5 * np.median(interval_s))
    played_s = measured_s - MOTION_START_S
    valid = np.ones(len(measured_s), bool)
    for start_s, end_s in zip(t_s[starts], t_s[starts + 1], strict=True):
        valid[(played_s > start_s) & (played_s < end_s)] = False
        edge = (np.abs(played_s - start_s) < 1e-7) | (np.abs(played_s - end_s) < 1e-7)
        valid[edge] = logged[edge]
    return valid


@dataclass(frozen=True)
class Hold:
    last_pose_s: float  # time at which the pose was measured
    next_pose_s: float


def expected_holds(measured_s: np.ndarray, valid: np.ndarray) -> list[Hold]:
    """Returns the gaps between received poses that exceed the stale timeout."""
    seen_s = measured_s[valid]
    return [Hold(a, b) for a, b in zip(seen_s[:-1], seen_s[1:], strict=True) if b - a > STALE_S + 1e-6]


def mode_changes(frames: dict) -> list[tuple[float, str, str]]:
    """Returns (time, mode, reason) of each change that FirmwareStatus reports, in the names of the DBC."""
    status = frames["FirmwareStatus"]
    names = {name: status.message.get_signal_by_name(name).choices for name in ("mode", "reason")}
    mode, reason = status.raw("mode"), status.raw("reason")
    changed = np.flatnonzero((np.diff(mode, prepend=-1) != 0) | (np.diff(reason, prepend=-1) != 0))
    return [(status.t_s[i], str(names["mode"][mode[i]]), str(names["reason"][reason[i]])) for i in changed]


def assert_modes(frames: dict, recording: Path, summary: dict) -> None:
    poses = frames["HandPose"]
    measured_s = poses.raw("t_us") * 1e-6
    assert np.allclose(measured_s, np.arange(len(poses)) * PERIOD_S, atol=1e-6)
    logged = poses.raw("valid") == 1
    valid = bus_validity(recording, measured_s, logged)
    assert np.array_equal(logged, valid), f"validity differs at {measured_s[logged != valid]} s"
    assert summary["tracker"]["lost"] == np.sum(~valid)

    changes = mode_changes(frames)
    holds = expected_holds(measured_s, valid)
    expected = [*BOOT_TO_COOPERATION, *[HOLD, RETURN] * len(holds), ("ready", "operator_stop")]
    assert [change[1:] for change in changes] == expected
    assert [(change["mode"], change["reason"]) for change in summary["modes"]] == expected

    entries_s = [t_s for t_s, *change in changes if tuple(change) == HOLD]
    returns_s = [t_s for t_s, *change in changes if tuple(change) == RETURN]
    for hold, entered_s, returned_s in zip(holds, entries_s, returns_s, strict=True):
        stale_s, back_s = hold.last_pose_s + LATENCY_S + STALE_S, hold.next_pose_s + LATENCY_S
        assert stale_s < entered_s < stale_s + REACTION_S, f"hold entered at {entered_s} s, stale at {stale_s} s"
        assert back_s < returned_s < back_s + REACTION_S, f"returned at {returned_s} s, poses at {back_s} s"
        assert_braking(frames, entered_s, back_s)


BOOT_TO_COOPERATION = [
    ("idle", "waiting_for_drives"),
    ("idle", "waiting_for_tracker"),
    ("ready", "inputs_ready"),
    ("cooperating", "operator_start"),
]
HOLD, RETURN = ("hold", "tracker_stale"), ("cooperating", "tracker_returned")


def assert_braking(frames: dict, from_s: float, until_s: float) -> None:
    """Checks that each joint comes to rest within v / a + 2.5 a / j and two ticks after the hold begins, and stays at
    rest. Once the deceleration has grown to its limit, in steps that the jerk limit allows, each command must change by
    the whole step of the acceleration limit, less one unit for rounding, until the deceleration must shrink again."""
    commands = frames["JointCmd"]
    first, end = np.searchsorted(commands.t_s, [from_s, until_s])
    speed = np.abs(raw_array(commands, "velocity_{}_radps")[first - 1 : end])
    ramp_ticks = VELOCITY_STEP_RAW / JERK_STEP_RAW
    ticks = np.arange(len(speed))[:, None]
    assert np.all(speed[ticks[:, 0] > 2 * ramp_ticks + 1] <= np.maximum(0, speed[0])), "a joint accelerates"
    assert np.all(speed[ticks > speed[0] / VELOCITY_STEP_RAW + 2.5 * ramp_ticks + 2] == 0), "a joint stops too late"
    shrinks_below = VELOCITY_STEP_RAW * (ramp_ticks + 1)  # below this speed the deceleration may already shrink
    before, after = speed[:-1], speed[1:]
    steady = (ticks[:-1] > 2 * ramp_ticks) & (after > shrinks_below)
    assert np.all(after[steady] <= before[steady] - (VELOCITY_STEP_RAW - 1)), "a joint brakes less than it may"
    at_rest = np.flatnonzero(~speed.any(axis=1))
    if len(at_rest) > 60:
        # after the first 50 ms, in which the drives settle
        position = measured_positions_rad(frames)[first + at_rest[0] + 50 : end - 1]
        assert np.ptp(position, axis=0).max() < 1.5 / PULSES_PER_RAD


# ---- numbers and repetition

# Columns that are empty and keys that are null because these scenes lack a second person, a held object, water and a
# crank.
ABSENT_COLUMNS = re.compile(r"second_|object_|force_|water_|crank_turns")
ABSENT_KEYS = re.compile(r"second_recording|people\[\d\]\.force_|gripper\.force_|water|object")


def assert_finite(trace: Path, ticks: int) -> None:
    text = trace.read_bytes()
    header, body = text.split(b"\n", 1)
    columns = header.decode().split(",")
    nonsense = re.search(rb"nan|inf", body)
    assert nonsense is None, body[: nonsense.end()].rsplit(b"\n", 1)[-1]
    for _ in range(2):  # twice, because a match consumes the comma that begins the next empty cell
        body = body.replace(b",,", b",nan,")
    body = body.replace(b",\n", b",nan\n")
    numeric = [i for i, name in enumerate(columns) if name != "mode"]
    table = np.loadtxt(io.BytesIO(body), delimiter=",", usecols=numeric, ndmin=2)
    value = dict(zip([columns[i] for i in numeric], table.T, strict=True))
    assert len(table) == ticks
    assert np.array_equal(np.round(1e3 * value.pop("t_s")), np.arange(ticks))

    target = np.array([value.pop(name) for name in columns if name.startswith("target_")])
    empty = np.isnan(target)
    assert np.array_equal(empty.all(axis=0), empty.any(axis=0)), "incomplete target"
    for name, column in value.items():
        missing = np.flatnonzero(np.isnan(column))
        if ABSENT_COLUMNS.match(name):
            assert len(missing) == ticks, f"{name}: a value although its object is absent"
            continue
        assert len(missing) == 0 or (name.startswith("dq") and list(missing) == [0]), f"{name}: empty at {missing[:3]}"
        largest = 1000.0 if name.startswith("clearance_") else 10.0
        assert np.nanmax(np.abs(column)) <= largest, f"{name}: up to {np.nanmax(np.abs(column))}"
    hand = np.array([value[name] for name in ("hand_qw", "hand_qx", "hand_qy", "hand_qz")])
    for rotation in (hand, target[3:, ~empty[0]]):
        assert np.allclose((rotation**2).sum(axis=0), 1.0, atol=1e-5)
    reach = np.array([value[name] for name in ("hand_x_m", "hand_y_m", "hand_z_m")])
    assert np.linalg.norm(reach - [[-0.035], [-0.111], [0.125]], axis=0).max() < 0.111 + 0.171 + 1e-3


def assert_finite_summary(value: object, path: str = "summary") -> None:
    if isinstance(value, dict):
        reason = value.get("not_measured")  # why figures of this group are missing; null if none is missing
        assert reason is None or reason.strip(), f"{path}.not_measured is {reason!r}"
        for key, item in value.items():
            if key != "not_measured" and not (reason and item is None):
                assert_finite_summary(item, f"{path}.{key}")
    elif isinstance(value, list):
        for i, item in enumerate(value):
            assert_finite_summary(item, f"{path}[{i}]")
    else:
        if ABSENT_KEYS.match(path.removeprefix("summary.")):
            assert value is None, f"{path} is {value} although its object is absent"
            return
        assert value is not None, f"{path} is null"
        assert isinstance(value, str) or np.isfinite(value), f"{path} is {value}"


def assert_equal_runs(a: Run, b: Run) -> None:
    for name in ("bus.log", "trace.csv"):
        assert filecmp.cmp(a.out / name, b.out / name, shallow=False), f"{name} differs between two runs"
    assert {**a.summary, "wall_s": 0} == {**b.summary, "wall_s": 0}


# ---- the campaign


@pytest.mark.parametrize(("scenario", "recording"), campaign())
def test_recording(tmp_path, scenario, recording):
    arguments = ("--scenario", scenario, "--tracker", recording)
    first = run(tmp_path / "first", *arguments).require_pass()
    assert_equal_runs(first, run(tmp_path / "second", *arguments).require_pass())
    assert first.summary["limits"]["violations"] == 0
    assert first.summary["bus"]["dropped"] == 0
    assert_finite_summary(first.summary)
    assert_finite(first.trace, first.summary["ticks"])
    frames = bus_log.read(first.log)
    assert_limits(frames)
    assert_modes(frames, recording, first.summary)


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_built_in_motion(tmp_path, scenario):
    """A built-in motion stays within the limits. The same seed repeats the run, and a different seed produces a
    different run."""
    first = run(tmp_path / "first", "--scenario", scenario, "--seed", 7).require_pass()
    assert_equal_runs(first, run(tmp_path / "second", "--scenario", scenario, "--seed", 7).require_pass())
    other = run(tmp_path / "other", "--scenario", scenario, "--seed", 8).require_pass()
    assert not filecmp.cmp(first.log, other.log, shallow=False)
    assert_limits(bus_log.read(first.log))


@pytest.mark.parametrize("seed", [1, 2, 3, 99, 2**64 - 1])
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_built_in_motion_passes_with_any_seed(tmp_path, scenario, seed):
    done = run(tmp_path / "out", "--scenario", scenario, "--seed", seed).require_pass()
    assert done.summary["seed"] == seed
    assert modes(done) == [*BOOT_TO_COOPERATION, ("ready", "operator_stop")]
