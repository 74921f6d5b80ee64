"""Checks `comanip convert` and `comanip decode` by reading their output back with python-can, scapy, mcap's reader and
cantools."""

from __future__ import annotations

import json
import struct

import can
import pytest
from bus_log import DBC
from comanip.bus import logs
from comanip.bus.frame import Frame
from comanip_command import call, require_refusal
from e2e import p05
from mcap.reader import make_reader
from scapy.layers.can import CAN, CANFD
from scapy.utils import RawPcapReader, rdpcap
from simulation import SHORT, shared

BEGIN_US = 1_700_000_000_000_000
# One frame of each kind that SocketCAN, candump and pcap distinguish.
KINDS = [
    Frame(BEGIN_US, 0x123, b"\xde\xad\xbe\xef", fd=False, brs=False),
    Frame(BEGIN_US + 1, 0x7FF, b"", fd=False, brs=False),
    Frame(BEGIN_US + 10, 0x12345678, b"\1\2", fd=False, brs=False, extended=True),
    Frame(BEGIN_US + 20, 0x00000012, b"\3", fd=False, brs=False, extended=True),
    Frame(BEGIN_US + 30, 0x321, bytes(4), fd=False, brs=False, remote=True),
    Frame(BEGIN_US + 999_999, 0x3F6, bytes(range(64)), fd=True, brs=True),
    Frame(BEGIN_US + 1_000_000, 0x3F7, bytes(12), fd=True, brs=False, esi=True),
    Frame(BEGIN_US + 1_000_001, 0x1ABCDEF0, bytes(48), fd=True, brs=True, esi=True, extended=True),
]


def message_of(frame: Frame) -> can.Message:
    return can.Message(
        timestamp=frame.t_us / 1e6, arbitration_id=frame.frame_id, is_extended_id=frame.extended,
        is_remote_frame=frame.remote,
        is_fd=frame.fd, bitrate_switch=frame.brs, error_state_indicator=frame.esi, dlc=len(frame.data),
        data=None if frame.remote else frame.data, channel=0,
    )  # fmt: skip


def facts(message: can.Message) -> tuple:
    return (
        round(message.timestamp * 1e6), message.arbitration_id, message.is_extended_id, message.is_remote_frame,
        message.is_fd,
        message.bitrate_switch, message.error_state_indicator, message.dlc, bytes(message.data),
    )  # fmt: skip


@pytest.fixture(scope="module")
def short():
    return shared(*SHORT).require_pass()


@pytest.fixture
def kinds(tmp_path):
    path = tmp_path / "kinds.log"
    path.write_text("".join(logs.candump_line(frame) + "\n" for frame in KINDS))
    return path


# ---- candump


def test_python_can_reads_the_candump_lines(kinds):
    found = [facts(message) for message in can.io.CanutilsLogReader(kinds)]
    assert found == [facts(message_of(frame)) for frame in KINDS]


@pytest.mark.parametrize("suffix", [".log", ".blf", ".asc"])
def test_logs_of_python_can_are_converted_to_candump_lines(tmp_path, suffix):
    """The converted lines are plain candump lines, although python-can's .log appends R or T to each line."""
    path, out = tmp_path / f"recorded{suffix}", tmp_path / "out.log"
    with can.Logger(path) as logger:
        for frame in KINDS:
            logger(message_of(frame))
    if suffix == ".log":
        assert all(line.endswith((" R", " T")) for line in path.read_text().splitlines())
    done = call("convert", path, out)
    assert done.returncode == 0, done.stderr
    expected = [facts(message) for message in can.LogReader(path)]
    assert [facts(message) for message in can.io.CanutilsLogReader(out)] == expected
    assert len(expected) == len(KINDS)


def test_trc_of_python_can(tmp_path):
    """Only classic data frames are tested, because python-can's TRC writer supports no other kind."""
    classic = [frame for frame in KINDS if not (frame.fd or frame.remote)]
    path, out = tmp_path / "recorded.trc", tmp_path / "out.log"
    with can.Logger(path) as logger:
        for frame in classic:
            logger(message_of(frame))
    assert call("convert", path, out).returncode == 0
    found = [(m.arbitration_id, m.is_extended_id, bytes(m.data)) for m in can.io.CanutilsLogReader(out)]
    assert found == [(frame.frame_id, frame.extended, frame.data) for frame in classic]


def test_candump_lines_survive_a_round_trip(tmp_path, short):
    out = tmp_path / "again.log"
    assert call("convert", short.log, out).returncode == 0
    assert out.read_bytes() == short.log.read_bytes()


def test_kernels_from_6_on_mark_fd_frames():
    plain, marked = (logs.parse_candump_line(f"(1.000000) can0 123##{flags}AABB") for flags in "15")
    assert plain == marked and plain.brs and plain.fd


# ---- pcap


def test_pcap_follows_the_specification(tmp_path, kinds):
    """The file follows the specification of pcap and of LINKTYPE_CAN_SOCKETCAN, byte for byte."""
    out = tmp_path / "out.pcap"
    assert call("convert", kinds, out).returncode == 0
    data = out.read_bytes()
    magic, major, minor, _, _, _, linktype = struct.unpack_from("<IHHiIII", data)
    assert (magic, major, minor, linktype) == (0xA1B2C3D4, 2, 4, 227)
    offset = 24
    for frame in KINDS:
        seconds, microseconds, included, original = struct.unpack_from("<IIII", data, offset)
        record = data[offset + 16 : offset + 16 + included]
        offset += 16 + included
        assert (seconds, microseconds) == divmod(frame.t_us, 10**6)
        assert included == original == (72 if frame.fd else 16)
        identifier = int.from_bytes(record[:4], "big")
        assert identifier & 0x1FFFFFFF == frame.frame_id
        assert (bool(identifier & 1 << 31), bool(identifier & 1 << 30), bool(identifier & 1 << 29)) == (
            frame.extended,
            frame.remote,
            False,
        )
        assert record[4] == len(frame.data)
        assert record[5] == (4 | frame.brs | 2 * frame.esi if frame.fd else 0)
        assert record[6:8] == b"\0\0"
        assert record[8:] == frame.data.ljust(64 if frame.fd else 8, b"\0")
    assert offset == len(data)


def test_scapy_reads_the_pcap(tmp_path, short):
    out = tmp_path / "out.pcap"
    assert call("convert", short.log, out).returncode == 0
    reader = RawPcapReader(str(out))
    assert reader.linktype == 227
    packets = rdpcap(str(out), count=3000)
    expected = list(can.io.CanutilsLogReader(short.log))[: len(packets)]
    assert len(packets) == 3000
    for packet, message in zip(packets, expected, strict=True):
        layer = packet[CANFD] if CANFD in packet else packet[CAN]
        assert (layer.identifier, layer.length, bytes(layer.data)[: layer.length]) == (
            message.arbitration_id, message.dlc, bytes(message.data),
        )  # fmt: skip
        assert round(float(packet.time) * 1e6) == round(message.timestamp * 1e6)


# ---- MCAP


def test_mcap_has_each_signal_as_cantools_decodes_it(tmp_path, short):
    out = tmp_path / "out.mcap"
    assert call("convert", short.log, out).returncode == 0
    messages = list(can.io.CanutilsLogReader(short.log))
    with open(out, "rb") as file:
        reader = make_reader(file)
        found = list(reader.iter_messages(log_time_order=False))
        summary = reader.get_summary()
    assert len(found) == len(messages)
    for (schema, channel, record), message in zip(found, messages, strict=True):
        layout = DBC.get_message_by_frame_id(message.arbitration_id)
        assert channel.topic == f"/can/{layout.name}"
        assert (channel.message_encoding, schema.encoding) == ("json", "jsonschema")
        assert record.log_time == 1000 * round(message.timestamp * 1e6)
    for schema, channel, record in found[:3000:7]:
        layout = DBC.get_message_by_name(channel.topic.removeprefix("/can/"))
        index = found.index((schema, channel, record))
        expected = layout.decode(bytes(messages[index].data))
        content = json.loads(record.data)
        assert content == {
            name: value if isinstance(value, int | float) else str(value) for name, value in expected.items()
        }
        assert json.loads(schema.data)["properties"].keys() == content.keys()
    assert summary.statistics.message_count == len(messages)


def test_mcap_keeps_frames_that_the_dbc_does_not_have(tmp_path, kinds):
    out = tmp_path / "out.mcap"
    assert call("convert", kinds, out).returncode == 0
    with open(out, "rb") as file:
        contents = [json.loads(record.data) for _, _, record in make_reader(file).iter_messages()]
    assert [(c["id"], c["data"]) for c in contents] == [(frame.frame_id, frame.data.hex()) for frame in KINDS]


# ---- usage errors


def test_bad_input_leaves_nothing_behind(tmp_path, kinds):
    bad = tmp_path / "bad.log"
    bad.write_text(kinds.read_text() + "(1.0) can0 xyz#00\n")
    (tmp_path / "bad.blf").write_bytes(b"not a blf")
    former = tmp_path / "former.pcap"
    former.write_text("former")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    require_refusal(call("convert", bad, former), "bad.log:9", "xyz#00")
    require_refusal(call("convert", tmp_path / "bad.blf", tmp_path / "new.log"), "bad.blf")
    require_refusal(call("convert", kinds, tmp_path / "new.txt"), "new.txt", ".pcap")
    require_refusal(call("convert", kinds, kinds), "kinds.log", "the log itself")
    require_refusal(call("convert", kinds, tmp_path / "no" / "such.log"), "No such file")
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


# ---- decode


@pytest.mark.parametrize(
    "command", [["monitor", "--once", "--log"], ["decode"], ["replay"], ["convert"]], ids=lambda c: c[0]
)
def test_an_empty_log_is_refused(tmp_path, command):
    (tmp_path / "empty.log").write_text("")
    target = [tmp_path / "new.log"] if command == ["convert"] else []
    require_refusal(call(*command, tmp_path / "empty.log", *target), "empty.log", "contains no frames")
    assert [path.name for path in tmp_path.iterdir()] == ["empty.log"]


def test_decode_has_cantools_signals_and_the_references_verdict(tmp_path, short):
    lines = short.log.read_text().splitlines()[:2000]
    place = next(i for i, line in enumerate(lines) if " 050#" in line and i > 1000)
    flipped = lines[place][:-1] + ("0" if lines[place][-1] != "0" else "1")
    text = "\n".join([*lines[:place], flipped, *lines[place + 1 :]])
    done = call("decode", "-", text=text)
    assert done.returncode == 0, done.stderr
    lines_out = done.stdout.splitlines()
    assert len(lines_out) == len(lines)
    for line, out in zip(text.splitlines(), lines_out, strict=True):
        frame_id, data = line.split()[2].split("##1")
        layout, payload = DBC.get_message_by_frame_id(int(frame_id, 16)), bytes.fromhex(data)
        assert f" {layout.name} [" in out
        number = layout.dbc.attributes.get("E2EDataId")
        if number is None:
            assert "[unprotected]" in out
        else:
            assert ("[wrong CRC]" not in out) == bool(p05.e2e_p05_check(payload, number.value))
        for name, value in layout.decode(payload).items():
            if not name.startswith("e2e_"):
                text_value = out.split(f"{name} ", 1)[1].split(",")[0].split(" ")[0]
                assert text_value == (f"{value:.7g}" if isinstance(value, float) else str(value))
    assert sum("[wrong CRC]" in out for out in lines_out) == 1


def test_decode_reports_lost_and_repeated_frames(short):
    lines = [line for line in short.log.read_text().splitlines() if " 010#" in line][:6]
    done = call("decode", text="\n".join([lines[0], lines[1], lines[1], lines[4]]))
    assert [line.split("[")[1].split("]")[0] for line in done.stdout.splitlines()] == [
        "ok",
        "ok",
        "repeated",
        "ok, 2 lost before it",
    ]


def test_decode_reads_candumps_screen_format():
    lines = ["  vcan0  701   [1]  05", " (1700000000.123456)  can0  1F334455   [2]  11 22",
             "  can0  010  [08]  00 01 02 03 04 05 06 07",
             "  can0  123   [4]  remote request"]  # fmt: skip
    done = call("decode", text="\n".join(lines))
    lines_out = done.stdout.splitlines()
    assert "701 FirmwareHeartbeat [unprotected] state operational" in lines_out[0]
    assert "1F334455" in lines_out[1] and "(1700000000.123456)" in lines_out[1] and "11 22" in lines_out[1]
    assert "010 FirmwareStatus [wrong CRC]" in lines_out[2]
    assert "remote request" in lines_out[3]
    require_refusal(call("decode", text="hello\n"), "standard input:1", "hello")


def test_decode_only(short):
    done = call("decode", short.log, "--only", "CommandAck", "--only", "FirmwareIdentity")
    assert {line.split()[3] for line in done.stdout.splitlines()} == {"CommandAck", "FirmwareIdentity"}
    require_refusal(call("decode", short.log, "--only", "Nothing"), "Nothing", "JointCmd")
