"""`comanip replay`: given a log, the C core reproduces the recorded frames, whatever clock stamped them, and the first
difference is reported. The logs come from the simulator and from a bench around the core. The tests modify some of
them, so that there is a difference to find."""

from __future__ import annotations

import re
from pathlib import Path

import can
import numpy as np
import pytest
from bus_log import DBC
from comanip._core import ffi, lib
from comanip.bus import logs
from comanip.bus.frame import Frame, has_right_crc
from comanip.errors import ToolError
from comanip.replay import Replay, Report
from comanip_command import call, require_refusal
from controller_bench import Bench
from e2e import p05
from simulation import EVENTFUL, EXPERIMENTS, SHORT, experiment, run, shared

ID = {message.name: message.frame_id for message in DBC.messages}
NAME = {message.frame_id: message.name for message in DBC.messages}
BY_FIRMWARE = {message.frame_id for message in DBC.messages if message.senders == ["Firmware"]}
COMPARED = BY_FIRMWARE - {ID["PortStatus"]}  # the port's counts cannot be derived from a log
EQUAL, DIFFERENT = 0, 1


def replay(frames: list[Frame]) -> Report:
    replaying = Replay(frames)
    for _ in replaying.run():
        pass
    return replaying.report()


def write(path: Path, frames: list[Frame]) -> Path:
    path.write_text("".join(logs.candump_line(frame) + "\n" for frame in frames))
    return path


@pytest.fixture(scope="module")
def eventful() -> list[Frame]:
    return list(logs.read(shared(*EVENTFUL).require_pass().log))


@pytest.fixture(scope="module")
def short() -> list[Frame]:
    return list(logs.read(shared(*SHORT).require_pass().log))


# ---- logs that replay without a difference


@pytest.mark.parametrize("scenario", EXPERIMENTS)
def test_all_experiments_replay_byte_for_byte(scenario):
    done = shared("--scenario", experiment(scenario), "--seed", 2)
    assert done.status in (0, 1), done.stderr
    replayed = call("replay", done.log)
    assert replayed.returncode == EQUAL, replayed.stdout + replayed.stderr
    lines = done.log.read_text().splitlines()
    sent = sum(int(line.split()[2][:3], 16) in COMPARED for line in lines)
    counts = re.search(r"EQUAL: (\d+) ticks, (\d+) received and (\d+) sent frames replayed;", replayed.stdout)
    assert int(counts[1]) >= done.summary["ticks"] - 1, "the last tick's frames may be too late for the log"
    assert abs(int(counts[3]) - sent) <= 5, "the log may end within a tick"


def test_log_times_do_not_matter(eventful, rng):
    """The timestamps may come from another machine's candump, with another clock, drift and jitter."""
    jitter_us = rng.integers(0, 400, len(eventful))
    moved = [
        frame._replace(t_us=1_700_000_000_000_000 + int(1.0002 * frame.t_us) + int(late))
        for frame, late in zip(eventful, jitter_us)
    ]
    report = replay(moved)
    assert report.difference is None
    assert report.fed > 4 * report.ticks, "each tick reads four drive states, and some read more"


@pytest.mark.parametrize("suffix", [".blf", ".asc", ".log"])
def test_logs_written_by_python_can(tmp_path, short, suffix):
    path = tmp_path / f"bus{suffix}"
    begin_s = 1_700_000_000
    with can.Logger(path) as logger:
        for frame in short:
            logger(can.Message(
                begin_s + frame.t_us / 1e6, frame.frame_id, False, data=frame.data, is_fd=True, bitrate_switch=True,
                channel=0, is_rx=frame.frame_id not in BY_FIRMWARE,
            ))  # fmt: skip
    done = call("replay", path)
    assert done.returncode == EQUAL, done.stdout + done.stderr


def test_a_log_may_end_anywhere(short):
    for end in range(3000, 3040):
        assert replay(short[:end]).difference is None, end


class RecordingBench(Bench):
    """A bench that logs its incoming and outgoing frames. The firmware's clock is not in the log."""

    def __init__(self, **options):
        super().__init__(now_us=2**32 - 150_000, **options)  # so that the clock wraps during the run
        self.by_id = False  # whether the frames sent in one tick appear on the bus in the order of their ids
        self.log: list[Frame] = []

    def tick(self, count: int = 1) -> None:
        for _ in range(count):
            super().tick()
            self.record()

    def record(self) -> None:
        at_us = 1000 * self.ticks
        inbox = [self.inbox.frame[i] for i in range(self.inbox.count)]
        self.log += [Frame(at_us, f.id, bytes(f.data[0 : f.length])) for f in inbox]
        sent = sorted(self.sent, key=lambda frame: frame[0]) if self.by_id else self.sent
        self.log += [Frame(at_us + 100, frame_id, data) for frame_id, data in sent]

    def lose(self, ticks: int) -> None:
        """Runs ticks during which the firmware is paused and misses the frames on the bus."""
        for _ in range(ticks):
            self.now_us += 1000
            self.ticks += 1
            self.inbox.count = 0
            if self.ticks % 4 == 0:
                self._receive(self._tracker_frame())
            for joint in range(4):
                self._receive(self._drive_frame(joint))
            self.log += [
                Frame(1000 * self.ticks, f.id, bytes(f.data[0 : f.length]))
                for f in (self.inbox.frame[i] for i in range(self.inbox.count))
            ]


def run_bench(bench: RecordingBench, rng: np.random.Generator, ticks: int = 1500) -> RecordingBench:
    """Runs a bench whose drives answer late and fall silent, with broken and repeated frames, and an operator who stops
    and starts."""
    bench.tick(60)
    bench.start(lib.TASK_TELEOP)
    for _ in range(ticks):
        draw = rng.random()
        bench.stamp_offset_us = -int(rng.integers(0, 900))
        bench.drives_answer = draw > 0.01 and (bench.drives_answer or rng.random() < 0.3)
        if rng.random() < 0.05:
            bench.receive_broken()
        if rng.random() < 0.02:
            bench.hand_valid = not bench.hand_valid
        if rng.random() < 0.02:
            bench.command(int(rng.choice([lib.COMMAND_STOP, lib.COMMAND_START, lib.COMMAND_LATCH, lib.COMMAND_CLUTCH])))
        else:
            bench.tick()
        bench.move_hand(rng.normal(0, 0.0005, 3))
    return bench


@pytest.mark.parametrize("seed", range(8))
def test_drives_that_fall_silent_and_frames_that_are_refused(seed):
    """Whether the firmware regards a drive as silent depends on times of reception, which are not in the log. The
    replay reaches the same decisions as the firmware."""
    bench = run_bench(RecordingBench(), np.random.default_rng(seed))
    report = replay(bench.log)
    assert report.difference is None, report.difference
    decoded = [DBC.decode_message("TickTrace", frame.data) for frame in bench.log if frame.frame_id == ID["TickTrace"]]
    assert {trace["drives_fresh"] for trace in decoded} == {0, 1}
    assert bench.controller.receiver.protocol.rejected > 20
    assert report.ticks == bench.ticks


@pytest.mark.parametrize("seed", range(3))
def test_damaged_frames_on_a_bus_without_filters(seed):
    """Damaged frames addressed to the firmware or to other nodes do not keep the sent frames from being reproduced. The
    first frame that the firmware never read is reported as the difference."""
    rng = np.random.default_rng(seed)
    bench = RecordingBench().until_ready().start(lib.TASK_TELEOP)
    past = 0
    for _ in range(400):
        if rng.random() < 0.2:
            bench.receive_broken_between_others()
            past += 1
        if rng.random() < 0.2:
            bench.receive_broken()
        bench.tick()
    assert past > 40 and bench.controller.receiver.protocol.rejected > 40
    between = [frame for frame in bench.log if frame.frame_id == ID["Clearance"]]
    assert len(between) == past
    report = replay(bench.log)
    assert report.ticks == bench.ticks
    assert "the replay does not compare" in report.difference.what and report.difference.recorded == between[0]
    assert replay([frame for frame in bench.log if frame.frame_id != ID["Clearance"]]).difference is None


@pytest.mark.parametrize("age_us", [1500, 2500, 2999, 3000, 3001, 5000])
def test_frames_that_were_read_late(age_us):
    """Frames may be read late, as after a pause of the process. Their age counts from their reception, which is not
    logged."""
    bench = RecordingBench()
    bench.tick(60)
    bench.start(lib.TASK_TELEOP)
    for silent_ticks in (1, 2, 3, 6):
        bench.stamp_offset_us = -age_us
        bench.tick(3)
        bench.drives_answer = False
        bench.tick(silent_ticks)
        bench.drives_answer, bench.stamp_offset_us = True, -300
        bench.tick(30)
        bench.command(lib.COMMAND_STOP)
        bench.command(lib.COMMAND_START)
    assert replay(bench.log).difference is None


@pytest.mark.parametrize("lost_ticks", [1, 2, 3, 9, 10, 40, 100])
def test_frames_that_the_firmware_lost(lost_ticks):
    """The firmware may lose frames, as when its queue overflows during a pause. The log contains these frames although
    the firmware never read them."""
    bench = RecordingBench()
    bench.tick(60)
    bench.start(lib.TASK_TELEOP)
    for _ in range(4):
        bench.tick(21)
        bench.lose(lost_ticks)
        bench.tick(50)
        bench.command(lib.COMMAND_STOP)
        bench.command(lib.COMMAND_START)
    assert replay(bench.log).difference is None


def test_a_restarted_firmware():
    first, second = RecordingBench(), RecordingBench()
    first.tick(777)
    second.ticks, second.now_us, second.sender = 5 * 777 // 4 * 4, 10**9, first.sender
    second.until_ready().start(lib.TASK_TELEOP).tick(300)
    report = replay(first.log + second.log)
    assert report.difference is None, report.difference
    assert (report.boots, report.ticks) == (2, 777 + second.ticks - 5 * 777 // 4 * 4)


def stored_parameters(rng: np.random.Generator):
    """Returns parameters that differ from the defaults, except `trace` and those that would leave no time to
    cooperate."""
    parameters = ffi.new("parameters_t *")
    lib.parameters_set_defaults(parameters)
    # each parameter's distance from its default, as a fraction of the distance from the default to the maximum
    share = 0.3 * rng.uniform(0, 1, lib.PARAMETER_COUNT)
    unstable = True
    while unstable:
        for i, part in enumerate(share):
            row = lib.parameter_table[i]
            if not row.integer:
                value = row.default_value + part * (row.maximum - row.default_value)
                assert lib.parameters_set(parameters, i, value) == lib.RESULT_ACCEPTED
        unstable = lib.parameter_set_check(parameters, 1e-3).verdict == lib.PARAMETER_SET_UNSTABLE
        share = share / 2
    lib.parameters_set(parameters, lib.PARAMETER_SPEED_FRACTION, 0.37)
    return parameters


@pytest.mark.parametrize("seed", range(4))
def test_a_firmware_that_booted_with_stored_parameters(seed):
    rng = np.random.default_rng(seed)
    bench = run_bench(RecordingBench(parameters=stored_parameters(rng)), rng, 700)
    report = replay(bench.log)
    assert report.difference is None, report.difference
    assert report.ticks == bench.ticks


def test_each_boot_has_its_own_parameters(rng):
    first = RecordingBench(parameters=stored_parameters(rng))
    first.tick(300)
    second = RecordingBench(parameters=stored_parameters(rng))
    second.ticks, second.now_us, second.sender = 4 * 500, 10**9, first.sender
    second.until_ready().start(lib.TASK_TELEOP).tick(200)
    report = replay(first.log + second.log)
    assert (report.difference, report.boots) == (None, 2)


def test_a_boot_with_an_invalid_store():
    defaults = ffi.new("parameters_t *")
    lib.parameters_set_defaults(defaults)
    bench = RecordingBench(parameters=defaults, boot_result=lib.RESULT_STORE_FAILED)
    bench.until_ready().start(lib.TASK_TELEOP).tick(100)
    assert replay(bench.log).difference is None


@pytest.mark.parametrize("early_ticks", range(0, 45, 4))
def test_a_stored_parameter_that_is_written_at_once(early_ticks, rng):
    """A stored parameter may be overwritten before or after it is announced. The replay must find out which, and
    because each status contains the speed fraction, a wrong guess would show."""
    bench = RecordingBench(parameters=stored_parameters(rng))
    bench.tick(early_ticks)
    bench.write(lib.PARAMETER_SPEED_FRACTION, 0.5)
    bench.tick(60)
    assert replay(bench.log).difference is None


@pytest.mark.parametrize("result", [lib.RESULT_ACCEPTED, lib.RESULT_STORE_FAILED, lib.RESULT_NOT_SUPPORTED])
def test_saves_end_with_the_recorded_result(result, rng):
    """Saves end with the recorded result, even if other answers with the same parameter and sequence number come in
    between."""
    bench = RecordingBench(parameters=stored_parameters(rng)).until_ready()
    assert (
        bench.access(lib.PARAMETER_READ, 0, 0.0) == lib.RESULT_ACCEPTED
    )  # a single request: among several at boot, the replay can be certain only of the last one
    bench.store_result = result
    for bench.store_ticks in (1, 2, 7, 40):
        sequence = bench.store_ticks
        for operation in (lib.PARAMETER_SAVE, lib.PARAMETER_READ, lib.PARAMETER_WRITE, lib.PARAMETER_SAVE):
            message = {"operation": operation, "parameter": 5, "sequence": sequence, "value": 12.0}
            bench.ask(ffi.new("parameter_access_t *", message))
            if operation != lib.PARAMETER_SAVE:
                bench.tick(int(rng.integers(1, 3)))
        bench.tick(50)
    results = [
        DBC.decode_message(f.frame_id, f.data, decode_choices=False)
        for f in bench.log
        if f.frame_id == ID["ParameterValue"]
    ]
    assert sum(counts["result"] == result and counts["sequence"] > 0 for counts in results) >= 4
    report = replay(bench.log)
    assert report.difference is None, report.difference


@pytest.mark.parametrize("order", ["sent", "by id"])
def test_a_save_while_parameters_are_announced(order):
    """The frames of a tick appear on the bus in the order of sending if the port sends them through a queue, or with
    the lowest id first. Both orders replay."""
    bench = RecordingBench()
    bench.by_id = order == "by id"
    bench.store_result = lib.RESULT_ACCEPTED
    bench.access(lib.PARAMETER_READ, 0, 0.0)
    for _ in range(10):
        assert bench.save() == lib.RESULT_ACCEPTED
    assert bench.ticks < lib.PARAMETER_COUNT
    bench.tick(60)
    assert replay(bench.log).difference is None


def test_an_answer_to_a_save_that_is_changed_is_a_difference(rng):
    bench = RecordingBench().until_ready()
    bench.store_result, bench.store_ticks = lib.RESULT_ACCEPTED, 5
    assert bench.save() == lib.RESULT_ACCEPTED
    bench.tick(20)
    place = [i for i, frame in enumerate(bench.log) if frame.frame_id == ID["ParameterValue"]][-1]
    for bit in rng.choice(8 * len(bench.log[place].data), 20, replace=False):
        assert replay(flipped(bench.log, place, int(bit))).difference.place == place
    assert replay(bench.log[:place] + bench.log[place + 1 :]).difference is None, "the save may not have ended yet"
    bench.tick(2)
    assert bench.save() == lib.RESULT_ACCEPTED
    assert replay(bench.log[:place] + bench.log[place + 1 :]).difference is not None, "a save must end before the next"


def test_at_recorded_pace(tmp_path, short):
    first_second = [frame for frame in short if frame.t_us < 10**6]
    done = call("replay", "--pace", write(tmp_path / "bus.log", first_second))
    assert done.returncode == EQUAL, done.stderr
    assert re.search(r"idle \(waiting_for_drives\)\n.*ready \(inputs_ready\)\n.*cooperating", done.stdout, re.DOTALL)
    took_s = float(re.search(r"; (\d+\.\d) s", done.stdout)[1])
    assert took_s >= 0.9


# ---- differences


LATEST_FRAMES = 2000  # number of frames replayed after a defect: 0.3 s, enough for the firmware to read and report it


def flipped(frames: list[Frame], place: int, bit: int) -> list[Frame]:
    data = bytearray(frames[place].data)
    data[bit // 8] ^= 1 << bit % 8
    return [*frames[:place], frames[place]._replace(data=bytes(data)), *frames[place + 1 :]]


def test_one_flipped_bit_is_reported_at_its_frame(eventful, rng):
    """A flipped bit is reported at its frame, whatever the frame's id and whichever bit of its data is flipped."""
    places = {frame_id: [i for i, frame in enumerate(eventful) if frame.frame_id == frame_id] for frame_id in NAME}
    tried = 0
    for frame_id, where in places.items():
        for place in rng.choice(where, min(len(where), 6), replace=False) if where else ():
            bit = int(rng.integers(8 * len(eventful[place].data)))
            difference = replay(flipped(eventful[: place + LATEST_FRAMES], int(place), bit)).difference
            assert difference is not None, (NAME[frame_id], place, bit)
            assert difference.place == place, (NAME[frame_id], place, bit, difference)
            tried += 1
    assert tried > 80


def test_the_first_difference_is_reported_with_time_id_and_signals(tmp_path, short):
    message = DBC.get_message_by_name("JointCmd")
    place = [i for i, frame in enumerate(short) if frame.frame_id == message.frame_id][2000]
    frame = short[place]
    signals = message.decode(frame.data, decode_choices=False)
    data = bytearray(message.encode(signals | {"velocity_2_radps": signals["velocity_2_radps"] + 0.25}))
    p05.e2e_p05_protect(data, message.dbc.attributes["E2EDataId"].value, increment_counter=False)
    changed = [*short[:place], frame._replace(data=bytes(data)), *short[place + 1 :]]
    done = call("replay", write(tmp_path / "bus.log", changed))
    assert done.returncode == DIFFERENT
    assert "DIFFERENT" in done.stdout
    assert f"at {frame.t_us / 1e6:.6f} s" in done.stdout
    assert f"frame {place + 1}, id 0x050 JointCmd" in done.stdout
    assert bytes(data).hex().upper() in done.stdout and frame.data.hex().upper() in done.stdout
    recorded, replayed = re.search(r"velocity_2_radps: recorded (\S+), replayed (\S+)", done.stdout).groups()
    assert float(recorded) - float(replayed) == pytest.approx(0.25)


@pytest.mark.parametrize(
    ("name", "what"),
    [("JointState1", "JointState1 with counter"), ("HandPose", "HandPose with counter"),
     ("OperatorCommand", "OperatorCommand with counter"),
     ("JointCmd", "other bytes"), ("FirmwareStatus", "other bytes"), ("TickTrace", "")],
)  # fmt: skip
def test_a_frame_missing_from_the_log(short, name, what):
    place = [i for i, frame in enumerate(short) if frame.frame_id == ID[name]][-1 if name == "OperatorCommand" else 200]
    difference = replay([*short[:place], *short[place + 1 :]]).difference
    assert difference is not None
    assert what in difference.what
    assert place - 40 <= difference.place <= place + 80, "the difference is close to the missing frame"


def test_a_frame_that_the_firmware_never_sent(short):
    place = [i for i, frame in enumerate(short) if frame.frame_id == ID["JointCmd"]][500]
    alien = Frame(short[place].t_us, ID["CommandAck"], bytes(8))
    difference = replay([*short[:place], alien, *short[place:]]).difference
    assert (difference.place, difference.recorded) == (place, alien)


def test_an_additional_frame_with_a_foreign_id_does_not_matter(short):
    foreign = [
        Frame(0, 0x555, b"\1\2"),
        Frame(0, ID["JointCmd"], bytes(8), extended=True),
        Frame(0, 4, bytes(8), error=True),
    ]
    assert replay([*short[:500], *foreign, *short[500:]]).difference is None


def test_a_trace_that_is_switched_off(tmp_path):
    done = run(tmp_path / "out", "--scenario", "teleop", "--duration", 3, "--param", "trace=0").require_pass()
    replayed = call("replay", done.log)
    assert replayed.returncode == DIFFERENT
    assert "the trace ends before this frame" in replayed.stdout


# ---- refused logs


def test_another_trace_is_refused_with_both_builds(tmp_path, short):
    message = DBC.get_message_by_name("FirmwareIdentity")
    place = next(i for i, frame in enumerate(short) if frame.frame_id == message.frame_id)
    data = bytearray(
        message.encode(
            message.decode(short[place].data, decode_choices=False)
            | {"build_hash": 0x1234567890ABCDEF, "trace_version": 77}
        )
    )
    p05.e2e_p05_protect(data, message.dbc.attributes["E2EDataId"].value, increment_counter=False)
    changed = [*short[:place], short[place]._replace(data=bytes(data)), *short[place + 1 :]]
    require_refusal(
        call("replay", write(tmp_path / "bus.log", changed)), "1234567890abcdef", f"{lib.replay_build_hash():016x}"
    )


def test_logs_that_cannot_be_replayed(tmp_path, short):
    with pytest.raises(ToolError, match="boot"):
        Replay(short[2000:])
    with pytest.raises(ToolError, match="TickTrace"):
        Replay([frame for frame in short if frame.frame_id != ID["TickTrace"]])
    (tmp_path / "bad.log").write_text("(0000000001.000000) vcan0 123##1AA\nnonsense\n")
    require_refusal(call("replay", tmp_path / "bad.log"), "bad.log:2", "nonsense", "candump -L")
    require_refusal(call("replay", tmp_path / "missing.log"), "missing.log", "No such file")
    require_refusal(call("replay", tmp_path / "log.xyz"), "log.xyz", ".blf")


def test_packed_layout_matches_the_compilers():
    offsets = [ffi.offsetof("can_frame_t", field) for field in ("timestamp_us", "id", "length", "fd", "data")]
    assert (offsets, ffi.sizeof("can_frame_t")) == ([0, 4, 6, 7, 8], 72)


@pytest.mark.parametrize("name", ["HandPose", "ClassicTickTrace"])
@pytest.mark.parametrize("length", [0, 1])
def test_a_frame_without_a_complete_header_is_damaged(name, length):
    frame_id = DBC.get_message_by_name(name).frame_id
    assert not has_right_crc(Frame(0, frame_id, bytes(length)))
