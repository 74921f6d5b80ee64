"""Checks the firmware on classic CAN with 250 Hz control, in lockstep with the simulated world. The firmware is
observed only through the bus."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from bus_log import CLASSIC_MESSAGES, DBC
from can_classic_bits import frame_duration_ns
from comanip._core import ffi, lib
from comanip.bus import logs
from comanip.bus.frame import Frame
from comanip.bus.transport import Profile, Sender
from comanip.replay import Replay, Report
from comanip_command import call
from live import Seen, is_authentic
from simulation import EVENTFUL, EXIT_WRONG_USE, EXPERIMENTS, REPOSITORY, Run, experiment, modes, run, shared
from test_bus_log import by_id, logged_frames

CLASSIC = ("--profile", "classic")
EQUAL, DIFFERENT = 0, 1
ID = {message.name: message.frame_id for message in DBC.messages}
NAME = {message.frame_id: message.name for message in DBC.messages}
PARTS = {  # the messages that are split
    "HandPose": ("HandPosition", "HandRotation"),
    "TickTrace": ("TickTrace", "TickTraceInputs", "TickTraceAge", "TargetPosition", "TargetRotation"),
    "JointCmd": tuple(f"JointCmd{joint}" for joint in range(4)),
    "TrackerStatus": ("TrackerClock", "TrackerStatus"),
}


@pytest.fixture(scope="module", params=EXPERIMENTS)
def experiment_run(request) -> Run:
    return shared("--scenario", experiment(request.param), "--seed", 1, *CLASSIC)


def test_the_experiments_succeed(experiment_run):
    assert experiment_run.require_pass().summary["bus"]["profile"] == "classic"


def test_their_logs_replay_byte_for_byte(experiment_run):
    replayed = call("replay", experiment_run.log)
    assert replayed.returncode == EQUAL, replayed.stdout + replayed.stderr
    ticks = int(re.search(r"EQUAL: (\d+) ticks", replayed.stdout)[1])
    assert abs(ticks - experiment_run.summary["ticks"] / 4) <= 2, "one firmware tick per 4 ms"


@pytest.fixture(scope="module")
def eventful() -> Run:
    return shared(*EVENTFUL, *CLASSIC).require_pass()


@pytest.fixture(scope="module")
def frames(eventful) -> list:
    return logged_frames(eventful.log)


def replay(frames: list) -> Report:
    replaying = Replay(frames)
    for _ in replaying.run():
        pass
    return replaying.report()


# ---- the bus


def test_all_frames_are_classic_and_in_the_dbc(eventful, frames):
    lines = eventful.log.read_text().splitlines()
    assert all(re.fullmatch(r"\(\d{10}\.\d{6}\) vcan0 [0-7][0-9A-F]{2}#(?:[0-9A-F]{2}){1,8}", line) for line in lines)
    names = {NAME[frame_id].removeprefix("Classic") for frame_id in by_id(frames)}
    periodic = {m.name.removeprefix("Classic") for m in CLASSIC_MESSAGES if m.cycle_time} | {"FirmwareHeartbeat"}
    absent = {f"Joint{kind}{joint}" for kind in ("Cmd", "State") for joint in range(4, 8)}
    events = {"OperatorCommand", "CommandAck", "ParameterAccess", "ParameterValue"}
    identity = {"FirmwareBuild", "FirmwareIdentity", "FirmwareTrace"}
    assert names == periodic - absent | events | identity


def test_every_frame_is_protected_and_none_is_missing(frames):
    for frame_id, sent in by_id(frames).items():
        if NAME[frame_id] == "FirmwareHeartbeat":
            continue
        assert all(is_authentic(Seen(0, frame_id, frame.data)) for frame in sent), NAME[frame_id]
        counters = np.array([frame.data[1] & 15 for frame in sent])
        assert counters[0] == 0 and np.all(np.diff(counters) % 16 == 1), NAME[frame_id]


def test_periods_are_those_of_the_dbc(eventful, frames):
    logged = by_id(frames)
    for message in CLASSIC_MESSAGES:
        if message.cycle_time and not re.search(r"Joint(Cmd|State)[4-7]$", message.name):
            expected = 1000 * eventful.summary["sim_s"] / message.cycle_time
            assert abs(len(logged[message.frame_id]) - expected) <= 1, message.name


def test_frames_last_as_long_as_their_bits(frames):
    """No two frames overlap. The time between the ends of two successive frames is at least the duration of the second,
    with its stuff bits, and equals that duration if the frames are back to back."""
    ends_us = np.array([frame.t_us for frame in frames])
    durations_us = np.array([frame_duration_ns(frame.frame_id, frame.data) for frame in frames]) / 1000
    waits_us = np.diff(ends_us) - durations_us[1:]
    assert waits_us.min() > -1, "log times are whole microseconds"
    assert np.sum(np.abs(waits_us) < 1) > len(frames) / 3, "the firmware's frames are back to back"


@pytest.mark.parametrize("name", PARTS)
def test_parts_have_equal_counters_and_come_together(frames, name):
    logged = by_id(frames)
    parts = [logged[ID["Classic" + part]] for part in PARTS[name]]
    whole = min(map(len, parts))
    counters = [[frame.data[1] & 15 for frame in part[:whole]] for part in parts]
    assert all(counter == counters[0] for counter in counters)
    first, last = (np.array([frame.t_us for frame in part[:whole]]) for part in (parts[0], parts[-1]))
    assert np.all(last > first) and np.all(last - first < 4000)


def test_cantools_decodes_the_log(eventful, frames):
    done = subprocess.run(
        [Path(sys.executable).parent / "cantools", "decode", "--single-line",
         REPOSITORY / "host_tools/comanip/comanip.dbc"],
        stdin=open(eventful.log), capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert re.findall(r":: (\w+)\([^\n]*\)$", done.stdout, re.MULTILINE) == [NAME[frame.frame_id] for frame in frames]


# ---- the firmware


def test_it_holds_in_the_gap_and_resumes(eventful):
    sequence = [mode for mode, _ in modes(eventful)]
    assert "hold" in sequence and sequence[sequence.index("hold") + 1] == "cooperating"


def test_commands_stay_within_the_limits(frames):
    """Commands change per 4 ms tick by at most the acceleration limit of 25 rad/s^2 times 4 ms, and stay within the
    speed limit of the arm's table."""
    logged = by_id(frames)
    for joint in range(4):
        message = DBC.get_message_by_name(f"ClassicJointCmd{joint}")
        speeds = np.array(
            [message.decode(f.data, decode_choices=False)["velocity_radps"] for f in logged[message.frame_id]]
        )
        assert np.abs(speeds).max() <= 4.76 + 1e-9
        assert np.abs(np.diff(speeds)).max() <= 4e-3 * 25 + 1e-9


def test_two_runs_are_byte_identical(eventful, tmp_path):
    again = run(tmp_path / "again", *EVENTFUL, *CLASSIC).require_pass()
    assert again.log.read_bytes() == eventful.log.read_bytes()


def test_a_task_can_be_defined(tmp_path):
    """The four parts of a TaskDefine form one message, the firmware accepts the message, and the log replays."""
    done = run(tmp_path / "out", "--scenario", "teleop", "--define", "constant:0,0,0.05:1,0,0,0:1,0,0,0:1", *CLASSIC)
    names = [NAME[frame.frame_id] for frame in logged_frames(done.log)]
    assert [names.count(f"ClassicTask{part}") for part in ("Define", "Translation", "Rotation", "Inverse")] == [1] * 4
    acks = [
        DBC.decode_message(f.frame_id, f.data)
        for f in logged_frames(done.log)
        if NAME[f.frame_id] == "ClassicCommandAck"
    ]
    assert ("define", "accepted") in {(str(ack["command"]), str(ack["result"])) for ack in acks}
    assert call("replay", done.log).returncode == EQUAL


# ---- replay


def test_an_eventful_log_replays_with_any_clock(eventful, rng):
    recorded = list(logs.read(eventful.log))
    moved = [
        frame._replace(t_us=1_700_000_000_000_000 + int(1.0002 * frame.t_us) + int(late))
        for frame, late in zip(recorded, rng.integers(0, 90, len(recorded)))
    ]
    assert replay(moved).difference is None


@pytest.mark.parametrize(
    "name",
    [
        "JointCmd2",
        "TickTrace",
        "TickTraceAge",
        "TargetRotation",
        "HandPosition",
        "HandRotation",
        "JointState1",
        "TrackerClock",
        "FirmwareStatus",
        "CommandAck",
        "Clearance",
    ],
)
def test_a_flipped_bit_is_reported_at_its_frame(eventful, rng, name):
    recorded = list(logs.read(eventful.log))
    places = [place for place, frame in enumerate(recorded) if frame.frame_id == ID["Classic" + name]]
    place = places[len(places) // 2]
    data = bytearray(recorded[place].data)
    bit = int(rng.integers(8 * len(data)))
    data[bit // 8] ^= 1 << bit % 8
    recorded[place] = recorded[place]._replace(data=bytes(data))
    report = replay(recorded)
    assert report.difference is not None and report.difference.place == place, report.difference


def test_a_flipped_bit_after_the_last_tick_is_reported(eventful):
    recorded = list(logs.read(eventful.log))[:6000]
    for place in range(len(recorded) - 40, len(recorded)):
        data = bytearray(recorded[place].data)
        data[-1] ^= 0x10
        spoilt = [*recorded[:place], recorded[place]._replace(data=bytes(data)), *recorded[place + 1 :]]
        if recorded[place].frame_id != ID["FirmwareHeartbeat"]:
            assert replay(spoilt).difference.place == place


def test_a_log_may_end_anywhere(eventful):
    recorded = list(logs.read(eventful.log))[:3000]
    for end in range(len(recorded) - 60, len(recorded)):
        assert replay(recorded[:end]).difference is None, end


def test_another_build_is_named_and_replayed(eventful, tmp_path):
    """If the build hash in one part of the identity differs, with valid protection, the replay reports another build
    and still succeeds."""
    from e2e import p02

    lines = []
    for line in eventful.log.read_text().splitlines():
        head, data = line.rsplit("#", 1)
        frame_id = int(head.split()[-1], 16)
        if NAME[frame_id] == "ClassicFirmwareBuild":
            changed = bytearray.fromhex(data)
            changed[4] ^= 0x55
            base = DBC.get_message_by_frame_id(frame_id).dbc.attributes["E2EDataId"].value
            p02.e2e_p02_protect(changed, bytes((base + 16 * n) % 256 for n in range(16)), increment_counter=False)
            data = changed.hex().upper()
        lines.append(f"{head}#{data}\n")
    path = tmp_path / "other.log"
    path.write_text("".join(lines))
    done = call("replay", path)
    assert done.returncode == 0 and "recorded by another build" in done.stdout and "EQUAL" in done.stdout


# ---- usage errors


@pytest.mark.parametrize("value", ["", "FD", "can2.0", "classic "])
def test_other_profiles_are_refused(tmp_path, value):
    done = run(tmp_path / "out", "--profile", value)
    assert done.status == EXIT_WRONG_USE
    assert f"--profile '{value}': expected fd or classic" in done.stderr
    assert not (tmp_path / "out").exists()


# ---- a hand's pose that is discarded in the tick in which the next pose arrives


TICK_US = 4000
NO_AGE = b"\xff\xff\xff"


def pose_signals(t_us: int) -> dict:
    return {"t_us": t_us, "x_m": 0.1, "y_m": 0.2, "z_m": 0.3, "qw": 0.5, "qx": 0.5, "qy": 0.5, "qz": 0.5, "valid": 1}


STATE = {
    "position_rad": 0.1, "velocity_radps": 0, "torque_Nm": 0, "mode": "brake", "error": "none", "temperature_degC": 20,
}  # fmt: skip


# For each kind of tracker, the time at which the pose that arrives at now_us was captured, or None if no pose arrives.
# From LATE_FROM_US on, every pose is stale.
LATE_FROM_US = 400_000
STALE_TRACKERS = {
    "late": lambda now_us: max(LATE_FROM_US, now_us - 30_000),
    "later than half a period of the classic stamp": lambda now_us: max((LATE_FROM_US + now_us) // 2, now_us - 200_000),
    "the last pose again and again": lambda now_us: LATE_FROM_US,
    "silent, then late": lambda now_us: now_us - 50_000 if now_us >= 1_416_000 else None,
    "invalid, then late": lambda now_us: now_us - 50_000 if now_us >= 1_416_000 else -1,
}


def log_of(captured_us) -> list[Frame]:
    """Returns all frames of a firmware with drives that stand still and a tracker that is late from LATE_FROM_US on.
    captured_us: one of STALE_TRACKERS; a negative time stands for an invalid pose."""
    sender, log = Sender(Profile.CLASSIC), []
    controller, outbox = ffi.new("controller_t *"), ffi.new("outbox_t *")
    lib.controller_init(controller, ffi.addressof(lib.arm_ik_hoap3_right), lib.CAN_PROFILE_CLASSIC)
    for now_us in range(TICK_US, 2_500_000, TICK_US):
        t_us = now_us if now_us < LATE_FROM_US else captured_us(now_us)
        messages = [(f"JointState{joint}", STATE) for joint in range(4)]
        if now_us % (2 * TICK_US) == 0 and t_us is not None:
            messages.append(("HandPose", pose_signals(max(0, t_us)) | {"valid": int(t_us >= 0)}))
        received = [frame for message in messages for frame in sender.frames(*message)]
        inbox = ffi.new("controller_inbox_t *", {"count": len(received)})
        for i, (frame_id, data) in enumerate(received):
            inbox.frame[i].id, inbox.frame[i].length, inbox.frame[i].timestamp_us = frame_id, len(data), now_us - 1000
            ffi.memmove(inbox.frame[i].data, data, len(data))
        lib.outbox_step(outbox, controller, now_us, inbox)
        sent = [(frame.id, bytes(frame.data[0 : frame.length])) for frame in outbox.frame[0 : outbox.count]]
        log += [Frame(now_us, *frame, fd=False, brs=False) for frame in received + sent]
    return log


@pytest.mark.parametrize("tracker", STALE_TRACKERS)
def test_a_hand_forgotten_as_its_pose_arrives_replays(tracker):
    """After a second of stale poses the firmware discards the hand's pose and the offset of the tracker's clock. Here a
    pose arrives in that same tick. TickTrace then reports no age, from which the replay normally computes when the pose
    was received."""
    log = log_of(STALE_TRACKERS[tracker])
    without_age = [frame.t_us for frame in log if frame.name == "ClassicTickTraceAge" and frame.data[2:5] == NO_AGE]
    forgotten_us = next(t_us for t_us in without_age if t_us > LATE_FROM_US)
    assert forgotten_us in [frame.t_us for frame in log if frame.name == "ClassicHandRotation"], "no pose arrives"
    assert replay(log).difference is None
