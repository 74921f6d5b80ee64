"""Checks the golden logs (tests/golden): given the recorded input, the firmware sends the recorded output.

The logs were recorded by the build named in their FirmwareIdentity. Any change of behaviour since that build makes
these tests fail.
"""

from __future__ import annotations

import dataclasses
import re
import sys
from collections import Counter

import pytest
from comanip.bus import logs
from comanip.bus.frame import decode, protected
from comanip.errors import ToolError
from comanip.replay import Replay
from comanip_command import call
from simulation import REPOSITORY

sys.path.insert(0, str(REPOSITORY / "tests" / "golden"))
import golden  # noqa: E402

CASES = [(run, profile) for run in golden.RUNS for profile in golden.PROFILES]


@pytest.fixture(scope="module")
def frames_of():
    """Reads each log only once."""
    read = {}

    def frames(run, profile):
        path = golden.path_of(run, profile)
        if path not in read:
            read[path] = list(logs.read(path))
        return read[path]

    return frames


def replayed(frames):
    replay = Replay(frames)
    for _ in replay.run():
        pass
    return replay.report()


@pytest.mark.parametrize(("run", "profile"), CASES, ids=lambda value: getattr(value, "name", value))
def test_the_firmware_repeats_the_recorded_output(frames_of, run, profile):
    frames = frames_of(run, profile)
    report = replayed(frames)
    assert report.difference is None, (
        f"{run.name}-{profile}: {report.difference}; if the change is intended, run `make golden`"
    )
    counted = Counter(frame.name for frame in frames)
    commands = counted["JointCmd"] if profile == "fd" else counted["ClassicJointCmd0"]
    traces = counted["TickTrace"] if profile == "fd" else counted["ClassicTickTrace"]
    assert traces > 1500 and report.ticks in (traces, traces - 1)  # the log may end within a tick
    assert commands in (traces, traces + 1) and report.compared > traces


@pytest.mark.parametrize(("run", "profile"), CASES, ids=lambda value: getattr(value, "name", value))
def test_a_log_goes_from_boot_through_start_to_stop(frames_of, run, profile):
    name = "FirmwareStatus" if profile == "fd" else "ClassicFirmwareStatus"
    statuses = [decode(frame) for frame in frames_of(run, profile) if frame.name == name]
    reasons = [str(status["reason"]) for status in statuses]
    assert reasons[0] in ("boot", "waiting_for_drives")
    assert "operator_start" in reasons
    if run.name == "teleop_gaps":
        assert {"tracker_stale", "tracker_returned"} <= set(reasons)
    else:
        assert reasons[-1] == "operator_stop"
    if run.name == "mirror":
        assert any(status["latched"] for status in statuses)


def test_both_profiles_all_experiments_and_the_size():
    assert {run.scenario.stem for run in golden.RUNS} == {"pour", "teleop", "mirror", "handover", "crank"}
    sizes = [golden.path_of(*case).stat().st_size for case in CASES]
    assert sum(sizes) < golden.MAX_BYTES
    assert len(list(golden.FOLDER.glob("*.log.xz"))) == len(CASES)


def test_the_changelog_gives_the_reason_of_each_recording():
    revisions = re.findall(r"Golden logs, revision (\d+): \S", (REPOSITORY / "CHANGELOG.md").read_text())
    assert [int(revision) for revision in revisions] == list(range(1, golden.REVISION + 1))


@pytest.mark.parametrize("profile", golden.PROFILES)
def test_a_change_of_behaviour_is_detected(frames_of, profile):
    """A single changed bit in one command is detected at that frame."""
    run = next(run for run in golden.RUNS if run.name == "handover")
    frames = list(frames_of(run, profile))
    name = "JointCmd" if profile == "fd" else "ClassicJointCmd0"
    place = [i for i, frame in enumerate(frames) if frame.name == name][2000]
    data = bytearray(frames[place].data)
    data[4] ^= 1
    frames[place] = frames[place]._replace(data=bytes(data))
    report = replayed(frames)
    assert report.difference is not None and report.difference.place == place


# ---- logs of other builds


def identity_changed(frames, **signals):
    place = next(i for i, frame in enumerate(frames) if frame.name == "FirmwareIdentity")
    old = frames[place]
    padded = old._replace(data=old.data.ljust(old.message.length, b"\0"))
    known = {"build_hash": 1, "trace_version": 1, "trace_hash": Replay(frames[:2000])._lib.replay_trace_hash()}
    data = protected("FirmwareIdentity", decode(padded) | known | signals, 0)
    return [*frames[:place], old._replace(data=data), *frames[place + 1 :]]


@pytest.fixture
def handover(frames_of):
    return list(frames_of(next(run for run in golden.RUNS if run.name == "handover"), "fd"))


def test_another_build_is_named_and_replayed(handover, tmp_path):
    frames = identity_changed(handover, build_hash=0xFEDCBA9876543210)
    report = replayed(frames)
    assert report.difference is None and report.other_build == 0xFEDCBA9876543210
    assert "FirmwareIdentity" in report.left_out
    path = tmp_path / "bus.log"
    path.write_text("".join(logs.candump_line(frame) + "\n" for frame in frames))
    done = call("replay", path)
    assert done.returncode == 0, done.stderr
    assert "recorded by another build, fedcba9876543210" in done.stdout and "EQUAL" in done.stdout


@pytest.mark.parametrize("change", [{"trace_version": 2}, {"trace_hash": 0x12345678}])
def test_another_trace_is_refused(handover, change):
    with pytest.raises(ToolError, match="expected the same; check out and build the revision that recorded it"):
        Replay(identity_changed(handover, **change))


def without_parameter(frames, number: int):
    """Returns the frames as a build without the given parameter would have sent them: without the parameter's
    ParameterValue frames, and with consecutive counters in all other ParameterValue frames."""
    counter, kept = 0, []
    for frame in frames:
        if frame.name == "ParameterValue":
            signals = decode(frame)
            if frame.message.decode(frame.data, decode_choices=False)["parameter"] == number:
                continue
            frame = frame._replace(data=protected("ParameterValue", signals, counter))
            counter += 1
        kept.append(frame)
    return kept


def test_a_build_with_fewer_parameters_is_replayed(handover):
    frames = without_parameter(identity_changed(handover, build_hash=2, parameter_count=42), 42)
    report = replayed(frames)
    assert report.difference is None, report.difference


def test_a_build_with_different_answers_is_detected(handover):
    frames = identity_changed(handover, build_hash=2)
    place = [i for i, frame in enumerate(frames) if frame.name == "ParameterValue"][20]
    signals = decode(frames[place])
    counter = frames[place].counter
    frames[place] = frames[place]._replace(
        data=protected("ParameterValue", signals | {"result": "out_of_range"}, counter)
    )
    assert replayed(frames).difference is not None


def test_a_message_missing_from_the_log_is_left_out_and_named(handover):
    frames = [frame for frame in identity_changed(handover, build_hash=2) if frame.name != "FirmwareStatus"]
    report = replayed(frames)
    assert report.difference is None
    always = {"FirmwareIdentity", "PortStatus"}  # the first always differs; the second depends on more than the log
    assert always | {"FirmwareStatus"} <= set(report.left_out)
    assert not {frame.name for frame in frames} & (set(report.left_out) - always)


def test_a_report_names_no_other_build_if_there_is_none(handover):
    report = replayed(identity_changed(handover, build_hash=Replay(handover)._lib.replay_build_hash()))
    assert dataclasses.replace(report, difference=None).other_build is None
    assert set(report.left_out) <= {"PortStatus"}, "PortStatus depends on more than the log"
