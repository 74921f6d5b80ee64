"""Checks the log of a run: standard tools read and decode it; its frames are protected, on time and complete; and a
replay of it makes the firmware send the same bytes."""

from __future__ import annotations

import re
import subprocess
from collections import deque
from dataclasses import dataclass
from pathlib import Path

import bus_log
import can
import numpy as np
import pytest
from bus_log import DBC, FD_MESSAGES
from can_fd_bits import frame_duration_ns
from comanip._core import ffi, lib
from e2e import p05
from simulation import EVENTFUL, REPOSITORY, SHORT, SIMULATOR, WRITTEN, Run, modes, run, shared

CANTOOLS = REPOSITORY / ".venv" / "bin" / "cantools"
SENT_BY_FIRMWARE = {message.frame_id for message in DBC.messages if message.senders == ["Firmware"]}
NAME = {message.frame_id: message.name for message in DBC.messages}
TICK_US = 1000


@dataclass(frozen=True)
class LoggedFrame:
    t_us: int
    frame_id: int
    data: bytes


def logged_frames(path: Path) -> list[LoggedFrame]:
    frames = []
    for line in path.read_text(encoding="ascii").splitlines():
        seconds, microseconds, identifier, data = re.fullmatch(
            r"\((\d{10})\.(\d{6})\) vcan0 ([0-7][0-9A-F]{2})#(?:#1)?((?:[0-9A-F]{2})*)", line
        ).groups()
        frames.append(LoggedFrame(10**6 * int(seconds) + int(microseconds), int(identifier, 16), bytes.fromhex(data)))
    return frames


def by_id(frames: list[LoggedFrame]) -> dict[int, list[LoggedFrame]]:
    result: dict[int, list[LoggedFrame]] = {}
    for frame in frames:
        result.setdefault(frame.frame_id, []).append(frame)
    return result


@pytest.fixture(scope="module")
def eventful() -> Run:
    return shared(*EVENTFUL).require_pass()


@pytest.fixture(scope="module")
def frames(eventful) -> list[LoggedFrame]:
    return logged_frames(eventful.log)


@pytest.fixture(scope="module")
def decoded(eventful) -> dict[str, bus_log.Frames]:
    return bus_log.read(eventful.log)


@pytest.fixture(scope="module")
def short() -> Run:
    return shared(*SHORT).require_pass()


# ---- standard tools


def test_cantools_decodes_every_line(eventful, frames):
    with open(eventful.log) as log:
        done = subprocess.run(
            [CANTOOLS, "decode", "--single-line", REPOSITORY / "host_tools" / "comanip" / "comanip.dbc"],
            stdin=log, capture_output=True, text=True, check=True,
        )  # fmt: skip
    names = re.findall(r":: (\w+)\([^\n]*\)$", done.stdout, re.MULTILINE)
    assert names == [NAME[frame.frame_id] for frame in frames]
    assert done.stdout.count("\n") == len(frames)
    assert done.stderr == ""


def test_python_can_reads_the_same_frames(short):
    expected = [(f.t_us, f.frame_id, f.data) for f in logged_frames(short.log)]
    messages = list(can.io.CanutilsLogReader(short.log))
    assert [(round(m.timestamp * 1e6), m.arbitration_id, bytes(m.data)) for m in messages] == expected
    assert all(m.is_fd and m.bitrate_switch and not m.is_extended_id for m in messages)


def test_bulk_decoder_agrees_with_cantools(frames, decoded):
    """The bulk decoder, which the other tests use, decodes the same raw values as cantools."""
    for frame_id, sent in by_id(frames).items():
        message = DBC.get_message_by_frame_id(frame_id)
        for i in np.linspace(0, len(sent) - 1, 50).astype(int):
            for signal, raw in message.decode(sent[i].data, decode_choices=False, scaling=False).items():
                layout = message.get_signal_by_name(signal)
                if not layout.is_float and layout.length < 63:
                    assert decoded[message.name].raw(signal)[i] == raw, (message.name, signal, i)


# ---- frames: one length, protection, counters, periods


def test_one_id_has_one_length_and_one_sender(frames):
    for frame_id, sent in by_id(frames).items():
        assert {len(frame.data) for frame in sent} == {DBC.get_message_by_frame_id(frame_id).length}
        assert len(DBC.get_message_by_frame_id(frame_id).senders) == 1


def test_every_header_verifies_and_counters_increment(frames):
    for frame_id, sent in by_id(frames).items():
        data_id = DBC.get_message_by_frame_id(frame_id).dbc.attributes.get("E2EDataId")
        if data_id is None:
            assert NAME[frame_id] == "FirmwareHeartbeat", f"{NAME[frame_id]} is not protected"
            continue
        for frame in sent:
            assert p05.e2e_p05_check(frame.data, data_id.value), f"{NAME[frame_id]} at {frame.t_us} us"
        counters = np.array([frame.data[2] for frame in sent])
        assert counters[0] == 0
        assert np.all(np.diff(counters) % 256 == 1), NAME[frame_id]


def test_periods_are_those_of_the_dbc(eventful, frames):
    duration_us = 1e6 * eventful.summary["sim_s"]
    logged = by_id(frames)
    for message in FD_MESSAGES:
        if not message.cycle_time or message.name in ("JointState4", "JointState5", "JointState6", "JointState7"):
            continue
        t_us = np.array([frame.t_us for frame in logged[message.frame_id]])
        period_us = 1000 * message.cycle_time
        assert abs(len(t_us) - duration_us / period_us) <= 1, message.name
        # a frame may have to wait for earlier frames of the same tick
        assert np.abs(np.diff(t_us) - period_us).max() < TICK_US, message.name


def test_nothing_is_lost_and_the_load_is_the_sum_of_the_frames(short):
    frames = logged_frames(short.log)
    bus = short.summary["bus"]
    assert bus["dropped"] == 0
    assert bus["frames"] == len(frames)
    duration_ns = np.array([frame_duration_ns(frame.frame_id, frame.data) for frame in frames])
    assert bus["load_percent_mean"] == pytest.approx(100e-9 * duration_ns.sum() / short.summary["sim_s"], rel=1e-7)

    end_ns = np.array([1000 * frame.t_us for frame in frames])  # up to 1 us too early: truncated to microseconds
    assert np.all(end_ns[1:] - duration_ns[1:] > end_ns[:-1] - 1000), "two frames overlap"
    window_ns = 10_000_000
    busy_ns = np.zeros(1 + end_ns[-1] // window_ns)
    for end, duration in zip(end_ns, duration_ns, strict=True):
        first, last = (end - duration) // window_ns, end // window_ns
        busy_ns[last] += min(duration, end - last * window_ns)
        if first != last:
            busy_ns[first] += last * window_ns - (end - duration)
    assert bus["load_percent_peak"] == pytest.approx(100 * busy_ns.max() / window_ns, abs=0.02)


# ---- announcements and answers


def test_boot_announces_firmware_and_parameters(short):
    logged = by_id(logged_frames(short.log))
    identity_message = DBC.get_message_by_name("FirmwareIdentity")
    (announced,) = logged[identity_message.frame_id]
    identity = identity_message.decode(announced.data)
    header = (REPOSITORY / "build" / "generated" / "comanip_identity.h").read_text()
    assert identity["build_hash"] == int(re.search(r"0x[0-9a-f]{16}", header)[0], 16)
    assert identity["arm"] == "hoap3_right"
    assert identity["joint_count"] == 4

    message = DBC.get_message_by_name("ParameterValue")
    names = message.get_signal_by_name("parameter").choices
    assert identity["parameter_count"] == len(names)
    values = [message.decode(frame.data) for frame in logged[message.frame_id]]
    assert [str(value["parameter"]) for value in values] == [str(names[i]) for i in range(len(names))]
    assert all(value["sequence"] == 0 and value["result"] == "accepted" for value in values)

    default = {str(value["parameter"]): value["value"] for value in values}
    help_text = subprocess.run([SIMULATOR, "--help"], capture_output=True, text=True, check=True).stdout
    listed = dict(re.findall(r"^ +(\w+) +\S+ to \S+?(?: [^,]+)?, (\S+)$", help_text, re.MULTILINE))
    assert listed.keys() == default.keys()
    assert all(float(listed[name]) == pytest.approx(default[name], rel=1e-5) for name in listed)
    rotation = [default[f"tracker_rotation_{axis}_rad"] for axis in "xyz"]
    assert rotation == pytest.approx([-np.pi / 2, 0, 0])  # equation (9) of the paper
    expected = {"motion_scale": 1, "stale_periods": 2.5, "latch_measured": 0, "trace": 1, "speed_fraction": 1}
    assert {name: default[name] for name in expected} == expected


def test_each_command_is_acknowledged(frames):
    command, ack = (DBC.get_message_by_name(name) for name in ("OperatorCommand", "CommandAck"))
    sent = [(f.t_us, command.decode(f.data)) for f in frames if f.frame_id == command.frame_id]
    answers = [(f.t_us, ack.decode(f.data)) for f in frames if f.frame_id == ack.frame_id]
    assert [str(request["command"]) for _, request in sent] == ["select", "start", "clutch", "latch", "stop"]
    for (sent_us, request), (answered_us, answer) in zip(sent, answers, strict=True):
        assert (answer["command"], answer["sequence"]) == (request["command"], request["sequence"])
        assert answer["result"] == "accepted"
        assert 0 < answered_us - sent_us <= 2 * TICK_US


def test_each_parameter_write_is_answered_with_the_value_in_force(frames):
    access, value = (DBC.get_message_by_name(name) for name in ("ParameterAccess", "ParameterValue"))
    sent = [(f.t_us, access.decode(f.data)) for f in frames if f.frame_id == access.frame_id]
    answers = [(f.t_us, value.decode(f.data)) for f in frames if f.frame_id == value.frame_id]
    assert {str(request["parameter"]): request["value"] for _, request in sent} == WRITTEN
    for sent_us, request in sent:
        (answered_us,) = (
            t_us
            for t_us, answer in answers
            if answer["sequence"] == request["sequence"]
            and answer["parameter"] == request["parameter"]
            and answer["value"] == request["value"]
            and answer["result"] == "accepted"
        )
        assert 0 < answered_us - sent_us <= 2 * TICK_US


# ---- replay


def trace_counters(frame: LoggedFrame) -> dict[int, int | None]:
    """Returns, by frame id, the counter of the last frame that the firmware read up to this tick, or None if it has not
    read any frame of this id. The bits of `received` are in the same order as the counter signals."""
    trace = DBC.get_message_by_name("TickTrace")
    signals = trace.decode(frame.data, decode_choices=False)
    received = {
        signal.name: bool(int(signals["received"]) >> bit & 1)
        for bit, signal in enumerate(s for s in trace.signals if s.name.endswith("_counter") and s.name[:3] != "e2e")
    }
    counters = {}
    for message in FD_MESSAGES:
        if "Firmware" in message.receivers:
            name = re.sub(r"(?<=[a-z])(?=[A-Z0-9])", "_", message.name).lower() + "_counter"
            counters[message.frame_id] = int(signals[name]) if received[name] else None
    return counters


def consumed(queue: deque[LoggedFrame], counters: dict, traced: dict) -> list[LoggedFrame]:
    """Removes from the queue the frames that the firmware read in this tick, and returns them in bus order."""
    taken = []
    while counters != traced:
        assert queue, f"the trace refers to frames that are not in the log: {traced}"
        frame = queue.popleft()
        counters[frame.frame_id] = frame.data[2]
        taken.append(frame)
    return taken


def replay(frames: list[LoggedFrame]) -> tuple[dict[int, list[bytes]], int]:
    """Runs the firmware with no input except the log. Returns the frames that the firmware sends, by id, and the number
    of frames fed to it. In each tick, the counts that the port would report are taken from the next PortStatus."""
    controller, inbox, outbox = (ffi.new(f"{name}_t *") for name in ("controller", "controller_inbox", "outbox"))
    lib.controller_init(controller, ffi.addressof(lib.arm_ik_hoap3_right), lib.CAN_PROFILE_FD)
    addressed = {message.frame_id for message in DBC.messages if "Firmware" in message.receivers}
    queue = deque(frame for frame in frames if frame.frame_id in addressed)
    trace, port_status = (DBC.get_message_by_name(name) for name in ("TickTrace", "PortStatus"))
    ports = [port_status.decode(f.data, decode_choices=False) for f in frames if f.frame_id == port_status.frame_id]
    counters, sent, fed = None, {}, 0
    for tick in frames:
        if tick.frame_id != trace.frame_id:
            continue
        traced = trace_counters(tick)
        counters = dict.fromkeys(traced) if counters is None else counters
        now_us = int(trace.decode(tick.data)["now_us"])
        taken = consumed(queue, counters, traced)
        assert all(frame.t_us <= now_us for frame in taken), "the firmware read a frame before it was received"
        inbox.count = len(taken)
        for i, frame in enumerate(taken):
            slot = inbox.frame[i]
            slot.timestamp_us, slot.id, slot.length = frame.t_us, frame.frame_id, len(frame.data)
            ffi.memmove(slot.data, frame.data, len(frame.data))
        for name, value in ports[min(len(sent.get(port_status.frame_id, ())), len(ports) - 1)].items():
            if not name.startswith("e2e_"):
                setattr(inbox.port, name, value)
        lib.outbox_step(outbox, controller, now_us, inbox)
        for i in range(outbox.count):
            frame = outbox.frame[i]
            sent.setdefault(frame.id, []).append(bytes(frame.data[0 : frame.length]))
        fed += len(taken)
    return sent, fed


def test_the_log_is_enough_to_replay(eventful, frames):
    """Given the frames that each tick read, the C core sends the same bytes as the firmware did in the run."""
    assert {"idle", "ready", "cooperating", "hold"} == {mode for mode, _ in modes(eventful)}
    sent, fed = replay(frames)
    recorded = {i: [f.data for f in part] for i, part in by_id(frames).items() if i in SENT_BY_FIRMWARE}
    assert fed > 4 * eventful.summary["ticks"], "each tick consumes the states of four drives"
    assert sent.keys() == recorded.keys()
    for frame_id, expected in recorded.items():
        differing = [i for i, (a, b) in enumerate(zip(sent[frame_id], expected, strict=False)) if a != b]
        assert not differing, f"{NAME[frame_id]}: {len(differing)} frames differ, the first is number {differing[0]}"
        assert len(expected) == len(sent[frame_id]), NAME[frame_id]


def test_trace_can_be_switched_off(tmp_path):
    done = run(tmp_path / "out", "--scenario", "teleop", "--duration", 4, "--param", "trace=0").require_pass()
    log = bus_log.read(done.log)
    written_s = log["ParameterAccess"].t_s[0]
    assert log["TickTrace"].t_s[-1] < written_s + 0.002
    assert log["JointCmd"].t_s[-1] > 3.99
    assert [mode for mode, _ in modes(done)][-2:] == ["cooperating", "ready"]
    assert done.summary["tracking"] == dict.fromkeys(done.summary["tracking"]), "tracking error without a target"
    assert "trace" in done.summary["reason"]
