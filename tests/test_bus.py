"""Checks the simulated CAN FD bus: frame durations against a bit-by-bit construction of the frame, arbitration against
a simple event model, and the log against standard tools."""

from __future__ import annotations

import subprocess
import sys

import can
import numpy as np
import pytest
from can_fd_bits import LENGTHS, bits, frame_duration_ns
from sim_bus import Bus, ffi, lib, make_frame

# Upper bounds of the frame durations by data length, with the usual assumption of one stuff bit per four bits.
WORST_CASE_US = {8: 55.8, 12: 63.8, 16: 71.8, 32: 104.8, 48: 136.8, 64: 168.8}


# ---- frame durations


def random_data(rng: np.random.Generator, length: int) -> bytes:
    """Returns random bytes, which in half of the cases have long runs of equal bits."""
    if rng.random() < 0.5:
        return rng.bytes(length)
    return bytes(rng.choice([0x00, 0xFF, 0x0F, 0xF0, 0x1F, 0xF8, 0x83, 0x7C, 0x10], length).astype(np.uint8))


def test_frame_time_equals_bitwise_construction(rng):
    for i in range(10_000):
        length = LENGTHS[i % len(LENGTHS)]
        identifier = int(rng.choice([rng.integers(0x800), 0x000, 0x7FF, 0x010, 0x07F, 0x7E0]))
        data = random_data(rng, length)
        duration_ns = lib.frame_time_ns(make_frame(identifier, data))
        assert duration_ns == frame_duration_ns(identifier, data), (hex(identifier), data.hex())
        if length in WORST_CASE_US:
            assert duration_ns <= 1000 * WORST_CASE_US[length]


@pytest.mark.parametrize("length", WORST_CASE_US)
def test_worst_frame_is_close_to_the_bound(length):
    """The longest frame is shorter than the bound by at most two stuff bits: a nominal stuff bit, which the fixed
    values of IDE, FDF, res and BRS make impossible, and a stuff bit at the end of the data."""
    sent = [0, *bits(0x078, 11), 0, 0, 1, 0, 1, 0, *bits(LENGTHS.index(length), 4)]
    run = next(i for i in range(1, 6) if sent[-1 - i] != sent[-1])
    last, data_bits = sent[-1], []
    for _ in range(8 * length):  # repeat the last bit, so that every four bits cause a stuff bit
        if run == 5:
            last, run = 1 - last, 1
        data_bits.append(last)
        run += 1
    data = bytes(int("".join(map(str, data_bits[i : i + 8])), 2) for i in range(0, len(data_bits), 8))
    duration_us = lib.frame_time_ns(make_frame(0x078, data)) / 1000
    assert WORST_CASE_US[length] - 1.4 <= duration_us <= WORST_CASE_US[length]


@pytest.mark.parametrize(("identifier", "length"), [(0x800, 8), (0x123, 9), (0x123, 63), (0x123, 65)])
def test_impossible_frames_have_no_duration(identifier, length):
    assert lib.frame_time_ns(ffi.new("can_frame_t *", {"id": identifier, "length": length, "fd": True})) < 0


# ---- bus


def model(traffic: list[tuple[int, int, bytes, int]]) -> list[tuple[int, bytes, int]]:
    """Models the bus for a list of (node, id, data, time when ready). When a frame ends, the ready frame with the
    lowest id starts."""
    earliest = {}
    waiting = []
    for order, (node, identifier, data, ready_ns) in enumerate(traffic):
        ready_ns = earliest[node, identifier] = max(ready_ns, earliest.get((node, identifier), 0))
        waiting.append((identifier, node, order, ready_ns, data))
    now_ns, played = 0, []
    while waiting:
        now_ns = max(now_ns, min(item[3] for item in waiting))
        winner = min(item for item in waiting if item[3] <= now_ns)
        waiting.remove(winner)
        now_ns += frame_duration_ns(winner[0], winner[4])
        played.append((winner[0], winner[4], now_ns))
    return played


@pytest.mark.parametrize("step_ns", [10**9, 1_000_000, 7_919])
def test_random_traffic_matches_the_model(rng, step_ns):
    bus = Bus(5)
    traffic = [
        (int(node), int(identifier), random_data(rng, int(rng.choice(LENGTHS))), int(ready_ns))
        for node, identifier, ready_ns in rng.integers((5, 40, 10**7), size=(250, 3))
    ]
    assert all(bus.send(*item) for item in traffic)
    for time_ns in range(step_ns, 4 * 10**7 + step_ns, step_ns):
        bus.run_until(time_ns)
    assert [heard[:3] for heard in bus.heard] == model(traffic)
    assert all(timestamp_us == end_ns // 1000 for *_, end_ns, timestamp_us in bus.heard)
    assert bus.statistics.frames == len(traffic)
    for node, received in enumerate(bus.received):
        own = [item for item in traffic if item[0] == node]
        assert len(received) == len(traffic) - len(own)


def test_handler_may_answer_and_arbitration_sees_it():
    bus = Bus(2)
    bus.reaction[1] = lambda identifier, end_ns: identifier == 0x50 and bus.send(1, 0x10, b"", end_ns)
    bus.send(0, 0x50, bytes(64))
    bus.send(0, 0x51, bytes(64))
    bus.run_until(10**6)
    assert [item[0] for item in bus.heard] == [0x50, 0x10, 0x51]


def test_frame_on_the_wire_ends_in_the_next_call():
    bus = Bus(1)
    bus.send(0, 0x123, bytes(8), 1000)
    end_ns = 1000 + frame_duration_ns(0x123, bytes(8))
    bus.run_until(1000)
    bus.run_until(end_ns - 1)
    assert bus.heard == []
    bus.send(0, 0x001, b"", 0)  # ready in the past, so it starts as soon as the wire is free
    bus.run_until(end_ns)
    assert [item[2] for item in bus.heard] == [end_ns]
    bus.run_until(10**6)
    assert bus.heard[1][2] == end_ns + frame_duration_ns(0x001, b"")


@pytest.mark.parametrize("before", [0x200, None])
def test_nothing_starts_exactly_at_the_end_of_a_call(before):
    """A frame that becomes ready exactly at the time up to which a call simulates does not start in this call. It takes
    part in arbitration in the next call, whether the wire was busy or idle."""
    bus = Bus(2)
    time_ns = frame_duration_ns(0x200, bytes(8))
    if before is not None:
        bus.send(0, before, bytes(8))
    bus.send(0, 0x300, b"", time_ns)
    bus.run_until(time_ns)
    bus.send(1, 0x100, b"", time_ns)
    bus.run_until(10**6)
    assert [item[0] for item in bus.heard][-2:] == [0x100, 0x300]


def test_frame_from_the_past_starts_now():
    bus = Bus(1)
    bus.run_until(5_000_000)
    bus.send(0, 0x123, b"", 1)
    bus.run_until(6_000_000)
    assert bus.heard[0][2] == 5_000_000 + frame_duration_ns(0x123, b"")


def test_full_queue_drops_and_counts():
    bus = Bus(2)
    accepted = [bus.send(0, 0x100 + i % 3, bytes([i])) for i in range(70)]
    assert accepted == [True] * 64 + [False] * 6
    assert bus.send(1, 0x200), "each node has its own queue"
    bus.run_until(10**8)
    assert bus.statistics.dropped == 6
    assert bus.statistics.frames == 65
    per_id = {i: [item[1][0] for item in bus.heard if item[0] == 0x100 + i] for i in range(3)}
    assert all(values == sorted(values) for values in per_id.values()), "frames with the same id keep their order"


def test_load_is_the_share_of_time_in_windows_of_10_ms(rng):
    bus = Bus(1)
    window_ns = 10_000_000
    starts_ns = np.sort(rng.choice(400, 180, replace=False)) * 200_000
    for start_ns in starts_ns:
        bus.run_until(int(start_ns))
        bus.send(0, int(rng.integers(0x800)), rng.bytes(64), int(start_ns))
    bus.run_until(10**8)
    busy_ns = np.zeros(10)
    for start_ns, (*_, end_ns, _us) in zip(starts_ns, bus.heard, strict=True):
        for window in range(10):
            busy_ns[window] += max(0, min(end_ns, (window + 1) * window_ns) - max(start_ns, window * window_ns))
    assert bus.statistics.busy_ns == busy_ns.sum()
    assert bus.statistics.load_percent_peak == pytest.approx(100 * busy_ns.max() / window_ns, abs=1e-9)


# ---- log


def write_log(path, frames: list[tuple[int, bytes, int]]) -> str:
    error = ffi.new("char[]", 300)
    log_path = ffi.new("char[]", str(path).encode())
    log = lib.candump_log_open(log_path, error, 300)
    if log == ffi.NULL:
        return ffi.string(error).decode()
    for identifier, data, end_ns in frames:
        lib.candump_log_write(log, make_frame(identifier, data), end_ns)
    return "" if lib.candump_log_close(log, error, 300) else ffi.string(error).decode()


@pytest.fixture
def log_frames(rng):
    ends_ns = np.cumsum(rng.integers(50_000, 10**9, 500))
    return [(int(rng.integers(0x800)), rng.bytes(int(rng.choice(LENGTHS))), int(end_ns)) for end_ns in ends_ns]


def test_log_line_has_candumps_format(tmp_path):
    path = tmp_path / "bus.log"
    assert write_log(path, [(0x50, b"\x01\xab", 170_999), (0x7FF, b"", 3_600_000_001_000)]) == ""
    assert path.read_text() == "(0000000000.000170) vcan0 050##101AB\n(0000003600.000001) vcan0 7FF##1\n"


def test_python_can_reads_the_log(tmp_path, log_frames):
    assert write_log(tmp_path / "bus.log", log_frames) == ""
    messages = list(can.LogReader(tmp_path / "bus.log"))
    assert [(m.arbitration_id, bytes(m.data)) for m in messages] == [frame[:2] for frame in log_frames]
    assert [round(m.timestamp * 1e6) for m in messages] == [frame[2] // 1000 for frame in log_frames]
    assert all(m.is_fd and m.bitrate_switch and not m.error_state_indicator and m.channel == "vcan0" for m in messages)


def test_cantools_decodes_the_log(tmp_path, dbc):
    described = [(m.frame_id, bytes(m.length), 10**6 * i) for i, m in enumerate(dbc.messages)]
    assert write_log(tmp_path / "bus.log", described) == ""
    (tmp_path / "comanip.dbc").write_text(dbc.as_dbc_string())
    with open(tmp_path / "bus.log") as log:
        command = [sys.executable, "-m", "cantools", "decode", "--single-line", tmp_path / "comanip.dbc"]
        lines = subprocess.run(command, stdin=log, capture_output=True, text=True, check=True).stdout.splitlines()
    assert [line.split(":: ")[1].split("(")[0] for line in lines] == [m.name for m in dbc.messages]


def test_log_errors_name_file_and_cause(tmp_path, log_frames):
    for frames in (log_frames, log_frames[:1]):  # the first error occurs while writing, the second when closing
        assert write_log("/dev/full", frames) == "/dev/full: the log is incomplete: No space left on device"
    missing = tmp_path / "missing" / "bus.log"
    assert write_log(missing, []) == f"{missing}: cannot be written: No such file or directory"
