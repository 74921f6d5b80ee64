"""The SLCAN code of the targets (hal/slcan) agrees with python-can's implementation and with the grammar of the SLCAN
dialect. The limits of lengths and queues are included."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import can
import cffi
import pytest
from c_declarations import declarations
from can.util import CAN_FD_DLC
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from slcan_oracle import StockSlcan, read

REPOSITORY = Path(__file__).resolve().parents[1]
SOURCES = ["hal/slcan/slcan.c", "hal/slcan/slcan_link.c"]
RX_FRAMES = 15  # usable slots: the 16-slot ring always keeps one empty
TX_BYTES = 1023


def link_declarations() -> str:
    """Returns the declarations with atomics replaced by their plain types."""
    text = declarations([REPOSITORY / "hal/slcan/slcan_link.h"], "-D_Atomic=")
    # evaluated here, because cffi does not evaluate array sizes
    text = re.sub(r"\[\(([^\]]*)\)\]", lambda size: f"[{eval(size[1])}]", text)
    return re.sub(r"\b(\d+)u\b", r"\1", text)


@pytest.fixture(scope="module")
def slcan(tmp_path_factory):
    folder = tmp_path_factory.mktemp("slcan")
    library = folder / "slcan.so"
    flags = ["-std=c11", "-O1", "-g", "-fPIC", "-shared", "-fsanitize=undefined", "-fsanitize-undefined-trap-on-error"]
    subprocess.run(["gcc", *flags, *SOURCES, "-o", str(library)], check=True, cwd=REPOSITORY)
    ffi = cffi.FFI()
    ffi.cdef(link_declarations())
    return ffi, ffi.dlopen(str(library))


@pytest.fixture(scope="module")
def stock():
    return StockSlcan()


def encode(slcan, can_id: int, data: bytes, fd: bool = True) -> bytes:
    ffi, library = slcan
    frame = ffi.new("can_frame_t *", {"id": can_id, "length": len(data), "data": data.ljust(64, b"\0"), "fd": fd})
    line = ffi.new("char[]", 139)
    return ffi.buffer(line, library.slcan_encode(frame, line))[:]


class Link:
    def __init__(self, slcan) -> None:
        self.ffi, self.library = slcan
        self.self = self.ffi.new("slcan_link_t *")

    @property
    def counters(self):
        return self.self.counters

    def put(self, stream: bytes, now_us: int = 0) -> None:
        for byte in stream:
            self.library.slcan_link_put_byte(self.self, byte, now_us)

    def receive(self) -> list[tuple[int, int, bytes]]:
        frames = []
        frame = self.ffi.new("can_frame_t *")
        while self.library.slcan_link_receive(self.self, frame):
            frames.append((frame.timestamp_us, frame.id, self.ffi.buffer(frame.data, frame.length)[:]))
        return frames

    def receive_fd(self) -> list[bool]:
        frame, fds = self.ffi.new("can_frame_t *"), []
        while self.library.slcan_link_receive(self.self, frame):
            fds.append(frame.fd)
        return fds

    def send(self, can_id: int, data: bytes) -> bool:
        frame = self.ffi.new(
            "can_frame_t *", {"id": can_id, "length": len(data), "data": data.ljust(64, b"\0"), "fd": True}
        )
        return self.library.slcan_link_send(self.self, frame)

    def take(self, limit: int = 1 << 20) -> bytes:
        taken = bytearray()
        byte = self.ffi.new("uint8_t *")
        while len(taken) < limit and self.library.slcan_link_take_byte(self.self, byte):
            taken.append(byte[0])
        return bytes(taken)


def message(can_id: int, data: bytes, fd: bool = True, switch: bool = True) -> can.Message:
    return can.Message(
        arbitration_id=can_id, data=data, is_extended_id=False, is_fd=fd, bitrate_switch=switch and fd, check=True
    )


@pytest.mark.parametrize("length", CAN_FD_DLC)
def test_every_length_is_written_and_read_as_python_can_does(slcan, stock, rng, length):
    for can_id in (0, 0x7FF, *(int(i) for i in rng.integers(0, 0x800, 20))):
        data = rng.bytes(length)
        line = encode(slcan, can_id, data)
        assert line == stock.line(message(can_id, data))
        back = stock.message(line)
        assert (back.arbitration_id, bytes(back.data), back.is_fd, back.bitrate_switch) == (can_id, data, True, True)
        link = Link(slcan)
        link.put(line, now_us=length)
        assert link.receive() == [(length, can_id, data)]


@pytest.mark.parametrize("length", CAN_FD_DLC)
def test_classic_frames_are_written_as_python_can_does(slcan, stock, rng, length):
    data = rng.bytes(length)
    line = encode(slcan, 0x5AB, data, fd=False)
    assert line == (stock.line(message(0x5AB, data, fd=False)) if length <= 8 else b"")


def test_received_frames_keep_the_fd_flag(slcan, stock):
    link = Link(slcan)
    link.put(b"".join(stock.line(message(0x100, b"ab", fd=fd)) for fd in (False, True, False)))
    assert link.receive_fd() == [False, True, False]


@pytest.mark.parametrize("fd, lengths", [(False, CAN_FD_DLC[:9]), (True, CAN_FD_DLC)])
def test_frames_without_bit_rate_switch_and_classic_ones_are_read_in_either_case(slcan, stock, rng, fd, lengths):
    link = Link(slcan)
    for length in lengths:
        data = rng.bytes(length)
        line = stock.line(message(0x5AB, data, fd=fd, switch=False))
        assert line[:1] == (b"d" if fd else b"t")
        link.put(line[:1] + line[1:].lower() + line)
        assert link.receive() == [(0, 0x5AB, data)] * 2
    assert link.counters.rx_malformed == 0


def test_frames_that_no_line_can_carry_are_refused_and_counted(slcan):
    link = Link(slcan)
    no_such_lengths = [n for n in range(65) if n not in CAN_FD_DLC]
    for can_id, data in [(0x800, b""), (0xFFFF, b""), *((1, bytes(n)) for n in no_such_lengths)]:
        assert encode(slcan, can_id, data) == b""
        assert not link.send(can_id, data)
    assert link.counters.tx_dropped == 2 + len(no_such_lengths)
    assert link.take() == b""


def test_the_lines_that_open_a_channel_are_not_errors(slcan, stock):
    link = Link(slcan)
    link.put(b"\a\r\rC\rS8\rY5\rM0\rA1\rO\rV\rz\r")
    link.put(stock.line(can.Message(arbitration_id=0x12345678, data=b"ab", is_extended_id=True)))
    link.put(stock.line(can.Message(arbitration_id=0x123, is_remote_frame=True, dlc=8, is_extended_id=False)))
    assert link.counters.rx_malformed == 0
    assert link.receive() == []


MALFORMED = {
    "unknown letter": b"q1230",
    "id with a letter that is no digit": b"b12G0",
    "id of 12 bits": b"b8000",
    "id too short": b"b12",
    "no length": b"b123",
    "length that is no digit": b"b123x",
    "FD length in a classic frame": b"t1239" + b"00" * 12,
    "no data": b"b1238",
    "half a byte": b"b12321",
    "one byte too few": b"b12331122",
    "one byte too many": b"b1232112233",
    "data of an empty frame": b"b12300",
    "data that is no digit": b"b12310.",
    "line feed": b"\nb1230",
    "space": b"b123 0",
    "zero byte": b"b123\x000",
    "high byte": b"b123\xb20",
    "bell inside": b"b123\a0",
    "endless": b"b" + b"0" * 100_000,
}


@pytest.mark.parametrize("line", MALFORMED.values(), ids=MALFORMED.keys())
def test_malformed_lines_are_counted_and_the_next_frame_is_read(slcan, line):
    link = Link(slcan)
    link.put(line + b"\r" + b"b1231AB\r")
    assert link.counters.rx_malformed == 1
    assert link.receive() == [(0, 0x123, b"\xab")]


def test_no_truncation_of_a_line_is_a_frame(slcan):
    line = encode(slcan, 0x123, bytes(range(64)))
    link = Link(slcan)
    for length in range(1, len(line) - 1):
        link.put(line[:length] + b"\r")
        assert link.receive() == []
    assert link.counters.rx_malformed == len(line) - 2


frames = st.tuples(
    st.integers(0, 0x7FF), st.sampled_from(CAN_FD_DLC).flatmap(lambda n: st.binary(min_size=n, max_size=n))
)
lines = frames.map(lambda f: b"b%03X%X" % (f[0], CAN_FD_DLC.index(len(f[1]))) + f[1].hex().encode() + b"\r")
digits = st.text("0123456789abcdefABCDEFtdbTDBrRzG\a\n ", max_size=40).map(lambda text: text.encode() + b"\r")
mutated = st.tuples(lines, st.integers(0, 138), st.binary(max_size=2)).map(
    lambda m: m[0][: m[1]] + m[2] + m[0][m[1] + 1 :]
)


@settings(max_examples=2000, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(parts=st.lists(st.one_of(lines, digits, mutated, st.binary(max_size=20)), max_size=RX_FRAMES // 3))
def test_any_bytes_are_read_by_the_grammar(slcan, parts):
    stream = b"".join(parts)
    expected, malformed = read(stream)
    link = Link(slcan)
    link.put(stream)
    assert [(can_id, data) for _, can_id, data in link.receive()] == expected[:RX_FRAMES]
    assert link.counters.rx_malformed == malformed
    assert link.counters.rx_overflow == len(expected[RX_FRAMES:])


def test_a_full_receive_ring_keeps_the_oldest_and_counts_the_rest(slcan):
    link = Link(slcan)
    for i in range(20):
        link.put(encode(slcan, i, bytes([i])), now_us=1000 + i)
    assert link.receive() == [(1000 + i, i, bytes([i])) for i in range(RX_FRAMES)]
    assert link.counters.rx_overflow == 20 - RX_FRAMES
    link.put(encode(slcan, 99, b"c"))
    assert link.receive() == [(0, 99, b"c")]


def test_a_full_transmit_ring_drops_whole_lines_and_counts_them(slcan, stock):
    link = Link(slcan)
    sent = [link.send(i, bytes([i]) * 64) for i in range(20)]
    assert sent == [i < TX_BYTES // 134 for i in range(20)]
    assert link.counters.tx_dropped == sent.count(False)
    room = TX_BYTES - sent.count(True) * 134
    taken = link.take(133 - room)
    assert not link.send(50, bytes(64))  # a line of 134 bytes does not fit into 133
    taken += link.take(1)
    assert link.send(51, bytes(64))
    expected = b"".join(stock.line(message(i, bytes([i]) * 64)) for i in range(sent.count(True)))
    assert taken + link.take() == expected + stock.line(message(51, bytes(64)))


def test_rings_wrap_without_loss_or_damage(slcan, stock, rng):
    link = Link(slcan)
    sent, taken, received = b"", b"", []
    for _ in range(2000):
        can_id, data = int(rng.integers(0x800)), rng.bytes(int(rng.choice(CAN_FD_DLC)))
        assert link.send(can_id, data)
        sent += stock.line(message(can_id, data))
        chunk = link.take(int(rng.integers(60, 140))) if len(sent) - len(taken) < 700 else link.take()
        taken += chunk
        link.put(chunk)
        received += [(i, d) for _, i, d in link.receive()]
    taken += (rest := link.take())
    link.put(rest)
    received += [(i, d) for _, i, d in link.receive()]
    assert taken == sent
    assert received == read(sent)[0]
    counters = link.counters
    assert (counters.rx_malformed, counters.rx_overflow, counters.rx_overrun, counters.tx_dropped) == (0, 0, 0, 0)


@pytest.mark.parametrize("place", range(1, 8))
def test_bytes_lost_by_the_uart_damage_their_line_only(slcan, place):
    link = Link(slcan)
    line = b"b123200FF\r"
    link.put(line[:place])
    link.library.slcan_link_overrun(link.self)
    link.put(line[place:] + line)
    assert link.receive() == [(0, 0x123, b"\x00\xff")]
    assert (link.counters.rx_overrun, link.counters.rx_malformed) == (1, 1)
