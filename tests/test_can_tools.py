"""Checks unmodified standard tools on a hub: can-utils and python-can's socketcan interface with the shim, and
python-can and cantools through socketcand. The tools show the frames that the simulator logged, and listening does not
change the run."""

from __future__ import annotations

import json
import re
import struct
import time
from dataclasses import dataclass
from pathlib import Path

import can
import pytest
from bus_log import DBC
from e2e import p05
from hub import CAN_EFF_FLAG, PATIENCE_S, SCRIPTS, WITH_CAN, Hub, Tool, classic, fd, running, tool, wait_until
from simulation import SIMULATOR, Run, run

# A run of SCENARIO has 14,000 frames. The hub queues more than that for each listener, so it drops no listener, however
# slow the machine is.
PLAIN = Path(__file__).parent / "scenarios" / "teleop_moves.yaml"  # the file that run() uses for "teleop"
SCENARIO = ("--scenario", "teleop", "--duration", 2)
LOG_LINE = re.compile(r"\(\d+\.\d+\) \w+ ([0-9A-F]+)#(#1)?([0-9A-F]*)(?: [RT])?")
MARKER = 0x7FE  # an id that the DBC does not use

Frame = tuple[int, bytes]


@pytest.fixture(scope="module")
def without_listeners(tmp_path_factory) -> Run:
    return run(tmp_path_factory.mktemp("without_listeners"), *SCENARIO).require_pass()


def frames_in(text: str) -> list[Frame]:
    """Returns the frames in the output of candump -L or of python-can's logger."""
    matches = (LOG_LINE.fullmatch(line.strip()) for line in text.splitlines())
    return [(int(match[1], 16), bytes.fromhex(match[3])) for match in matches if match]


def logged(finished: Run) -> list[Frame]:
    return frames_in(finished.log.read_text())


def require_protected(frames: list[Frame]) -> None:
    """Checks that each frame can be decoded with the DBC and has a valid end-to-end header."""
    for frame_id, data in frames:
        message = DBC.get_message_by_frame_id(frame_id)
        message.decode(data)
        data_id = message.dbc.attributes.get("E2EDataId")
        assert data_id is None or p05.e2e_p05_check(data, data_id.value), message.name


def tap(hub: Hub) -> tuple[str, ...]:
    """Returns the options that connect python-can's programs to socketcand."""
    return ("-i", "socketcand", "-c", "vcan0", "--bus-kwargs", "host=127.0.0.1", f"port={hub.port}")


@dataclass
class Listened:
    run: Run
    text: dict[str, str]  # output of each listener
    through_tap: list[can.Message]


@pytest.fixture(scope="module")
def with_listeners(tmp_path_factory) -> Listened:
    """Runs the simulator with the listening tools on its hub, and with two more clients, one that never reads and one
    that tries to send."""
    python_can = (
        "import can\n"
        "with can.Bus('vcan0', interface='socketcan', fd=True, local_loopback=True) as bus:\n"
        "    try:\n"
        "        for m in bus:\n"
        "            data = bytes(m.data).hex().upper()\n"
        "            print(f'({m.timestamp:.6f}) {m.channel} {m.arbitration_id:03X}##1{data}')\n"
        "    except can.CanError as error: print(error)\n"
    )
    commands = {
        "candump": ("candump", "-L", "vcan0"),
        "candump any": ("candump", "-L", "any"),
        "candump filtered": ("candump", "-L", "vcan0,180:7F0"),
        "python-can": (SCRIPTS / "python", "-c", python_can),
    }
    with (
        running("--listen-only", "--socketcand", "0") as hub,
        can.Bus("vcan0", interface="socketcand", host="127.0.0.1", port=hub.port) as bus,
    ):
        tools = {name: Tool(hub, WITH_CAN, *command) for name, command in commands.items()}
        stalled, talking = hub.connect(), hub.connect()
        hub.wait_for_clients(len(tools) + 2)
        talking.send(classic(0x010, bytes(8)))  # an imitation of FirmwareStatus, which the hub must not forward
        finished = run(
            tmp_path_factory.mktemp("with_listeners"), *SCENARIO, "--hub", "vcan0", environment=hub.environment
        )
        expected = len(logged(finished))
        messages = [bus.recv(PATIENCE_S) for _ in range(expected)]
        assert hub.stop() == 0
        text = {name: started.wait() for name, started in tools.items()}
        for started in tools.values():
            started.close()
        stalled.close()
        talking.close()
        assert "may only listen" in hub.stderr()
        return Listened(finished.require_pass(), text, messages)


# ---- live listening to a run


def test_listening_changes_nothing(without_listeners, with_listeners):
    assert with_listeners.run.log.read_bytes() == without_listeners.log.read_bytes()
    assert with_listeners.run.trace.read_bytes() == without_listeners.trace.read_bytes()
    assert {**with_listeners.run.summary, "wall_s": 0} == {**without_listeners.summary, "wall_s": 0}
    assert with_listeners.run.stderr == ""


@pytest.mark.parametrize("listener", ["candump", "candump any", "python-can"])
def test_listeners_receive_what_was_logged(with_listeners, listener):
    assert frames_in(with_listeners.text[listener]) == logged(with_listeners.run)
    assert "No such device" in with_listeners.text[listener], "the interface disappears with the hub"


def test_frames_shown_by_candump_are_protected(with_listeners):
    require_protected(frames_in(with_listeners.text["candump"]))


def test_candump_filters(with_listeners):
    expected = [frame for frame in logged(with_listeners.run) if frame[0] & 0x7F0 == 0x180]
    assert len(expected) > 1000
    assert frames_in(with_listeners.text["candump filtered"]) == expected


def test_candump_shows_wall_clock_times(with_listeners):
    times = [float(line[1:18]) for line in with_listeners.text["candump"].splitlines() if line.startswith("(")]
    assert all(0 <= later - earlier < 60 for earlier, later in zip(times[:-1], times[1:], strict=True))
    assert abs(times[-1] - time.time()) < 3600


def test_python_can_receives_the_run_through_socketcand(with_listeners):
    frames = [(message.arbitration_id, bytes(message.data)) for message in with_listeners.through_tap]
    assert frames == logged(with_listeners.run)
    require_protected(frames)


def test_the_run_starts_and_stops_its_own_hub(tmp_path, without_listeners):
    # The run's folder for hubs has no hub yet, so the run starts its own and does not use `elsewhere`.
    with running() as elsewhere:
        environment = {**elsewhere.environment, "COMANIP_HUB_DIR": str(tmp_path / "hubs")}
        finished = run(tmp_path / "out", *SCENARIO, "--hub", "vcan0", environment=environment, quiet=False)
    assert finished.require_pass().log.read_bytes() == without_listeners.log.read_bytes()
    assert "the bus is live on its own hub vcan0; to listen in another terminal: make candump" in finished.stdout
    assert [file.name for file in (tmp_path / "hubs").iterdir()] == ["vcan0.lock"]


def test_a_hub_that_goes_away_does_not_disturb_the_run(tmp_path, without_listeners):
    with running("--listen-only", "--socketcand", "off") as hub:
        command = ("--scenario", PLAIN, "--duration", 2, "--out", tmp_path, "--hub", "vcan0", "--real-time", "--quiet")
        with tool(hub, SIMULATOR, *command) as simulator:
            listener = hub.connect()
            listener.recv(100)
            hub.process.kill()
            text = simulator.wait()
            assert simulator.process.returncode == 0
            listener.close()
    assert (tmp_path / "bus.log").read_bytes() == without_listeners.log.read_bytes()
    assert "the hub closed the connection or stopped responding" in text
    assert "frames were not published on the hub" in text


def test_real_time_is_not_faster(tmp_path, without_listeners):
    started = time.monotonic()
    finished = run(tmp_path / "out", *SCENARIO, "--real-time").require_pass()
    assert time.monotonic() - started > finished.summary["sim_s"] - 0.01
    assert finished.summary["wall_s"] > finished.summary["sim_s"] - 0.01
    assert finished.log.read_bytes() == without_listeners.log.read_bytes()


# ---- can-utils under the shim


@pytest.fixture
def hub():
    with running("--socketcand", "0") as started:
        yield started


def with_can(hub: Hub, *command: object, status: int = 0) -> str:
    with tool(hub, WITH_CAN, *command) as started:
        text = started.wait()
        assert started.process.returncode == status, text
        return text


def test_canplayer_replays_the_log_to_candump(hub, without_listeners):
    with tool(hub, WITH_CAN, "candump", "-L", "vcan0") as candump:
        hub.wait_for_clients(1)
        with_can(hub, "canplayer", "-t", "-I", without_listeners.log, "vcan0=vcan0")
        assert hub.stop() == 0
        assert frames_in(candump.wait()) == logged(without_listeners)


@pytest.mark.parametrize(
    ("text", "packet"),
    [
        ("123#DEADBEEF", classic(0x123, b"\xde\xad\xbe\xef")),
        ("1ABCDEF0#", classic(CAN_EFF_FLAG | 0x1ABCDEF0)),
        ("7FF#R", classic(0x7FF | 0x40000000)),
        ("123##1" + "AB" * 64, fd(0x123, b"\xab" * 64)),
    ],
)
def test_cansend_sends(hub, text, packet):
    listener = hub.connect()
    hub.wait_for_clients(1)
    with_can(hub, "cansend", "vcan0", text)
    got = listener.recv(100)
    assert got[:5] == packet[:5]
    assert got[8:] == packet[8:]
    assert len(got) == len(packet)


def test_candump_receives_cangen(hub):
    with tool(hub, WITH_CAN, "candump", "-L", "vcan0") as candump:
        hub.wait_for_clients(1)
        with_can(hub, "cangen", "vcan0", "-n", 500, "-g", 0, "-I", "i", "-D", "i", "-L", 8)
        hub.stop()
        assert frames_in(candump.wait()) == [(i % 0x800, i.to_bytes(8, "little")) for i in range(500)]


def test_cansniffer_shows_frames_on_a_terminal(hub):
    sender = hub.connect()
    with tool(hub, WITH_CAN, "cansniffer", "vcan0", terminal=True) as sniffer:
        hub.wait_for_clients(2)

        def shown() -> bool:
            sender.send(classic(0x123, b"\xde\xad\xbe\xef"))
            plain = re.sub(r"\x1b\[[0-9;]*[A-Za-z]", "", sniffer.text())
            return re.search(r"\b123\b.*DE ?AD ?BE ?EF", plain) is not None

        wait_until(shown, "frame 123 in cansniffer")


def test_canbusload_counts_frames(hub):
    sender = hub.connect()
    with tool(hub, WITH_CAN, "canbusload", "vcan0@1000000", terminal=True) as load:
        hub.wait_for_clients(2)

        def counted() -> bool:
            sender.send(classic(0x123, bytes(8)))
            return any(int(count) > 0 for count in re.findall(r"vcan0@1000000 +(\d+)", load.text()))

        wait_until(counted, "frames counted by canbusload")


def test_an_interface_without_hub_does_not_exist(hub):
    assert "No such device" in with_can(hub, "candump", "vcan9", status=1)


def test_other_sockets_are_untouched(hub):
    program = (
        "import socket, threading\n"
        "server = socket.create_server(('127.0.0.1', 0))\n"
        "client = socket.create_connection(server.getsockname()); peer, _ = server.accept()\n"
        "client.sendall(b'x' * 100); assert peer.recv(200, socket.MSG_WAITALL | socket.MSG_DONTWAIT)\n"
        "a, b = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM); a.send(b''); assert b.recv(10) == b''\n"
        "client.close(); peer.recv(200); print(socket.if_nametoindex('lo'), socket.if_indextoname(1))\n"
    )
    assert with_can(hub, SCRIPTS / "python", "-c", program) == "1 lo\n"


# ---- python-can's socketcan interface under the shim


def under_shim(hub: Hub, program: str) -> str:
    return with_can(hub, SCRIPTS / "python", "-c", "import can, socket, struct, time\n" + program)


def test_socketcan_sends_both_kinds(hub):
    listener = hub.connect()
    hub.wait_for_clients(1)
    under_shim(
        hub,
        "with can.Bus('vcan0', interface='socketcan', fd=True) as bus:\n"
        "    bus.send(can.Message(arbitration_id=0x12, data=b'abc', is_extended_id=False))\n"
        "    bus.send(can.Message(arbitration_id=0x13, data=bytes(48), is_fd=True, bitrate_switch=True))\n",
    )
    packet = listener.recv(100)
    assert (len(packet), packet[:5], packet[8:]) == (16, classic(0x12, b"abc")[:5], classic(0x12, b"abc")[8:])
    packet = listener.recv(100)
    assert (len(packet), packet[:5]) == (72, fd(CAN_EFF_FLAG | 0x13, bytes(48))[:5])


def test_socketcan_receives_its_own_frames_only_on_request(hub):
    text = under_shim(
        hub,
        "a = can.Bus('vcan0', interface='socketcan', receive_own_messages=True)\n"
        "b = can.Bus('vcan0', interface='socketcan')\n"
        "c = can.Bus('vcan0', interface='socketcan', local_loopback=False)\n"
        "for i, bus in enumerate((a, b, c)): bus.send(can.Message(arbitration_id=i, is_extended_id=False))\n"
        "print([[m.arbitration_id for m in iter(lambda: bus.recv(0.5), None)] for bus in (a, b, c)])\n"
        "a.shutdown(); b.shutdown(); c.shutdown()\n",
    )
    heard_by = json.loads(text)
    assert [sorted(ids) for ids in heard_by] == [[0, 1], [0], [0, 1]]


FILTERS = [
    (0x123, 0x7FF), (0x20000100, 0x7F0), (0x80000123, 0x9FFFFFFF), (0x123, 0x1FFFFFFF), (0, 0),
    (0x40000000, 0x40000000),
    (0x1123, 0x80001FFF),  # compared as 11-bit ids, so the two higher bits are ignored
]  # fmt: skip
SENT = [0x000, 0x100, 0x10F, 0x110, 0x123, 0x124, 0x7FF, 0x80000123, 0x80000100, 0x9FFFFFFF, 0x40000123, 0xC0000123]


def kernel_accepts(received: int, filters: list[tuple[int, int]], join: bool) -> bool:
    """Returns whether the kernel would accept the id, according to its documentation: (received & mask) == (id & mask),
    negated if the id has CAN_INV_FILTER."""
    matches = []
    for can_id, mask in filters:
        if mask & 0x80000000 and not can_id & 0x80000000:
            mask &= 0xC00007FF
        matches.append(((received & mask) == (can_id & ~0x20000000 & mask)) != bool(can_id & 0x20000000))
    return all(matches) and bool(matches) if join else any(matches)


@pytest.mark.parametrize("join", [False, True])
@pytest.mark.parametrize(
    "filters",
    [[], *[[pair] for pair in FILTERS], FILTERS[:2], FILTERS[1:4], [(0x20000123, 0x7FF), (0x20000124, 0x7FF)]],
)
def test_receive_filters_match_the_kernels(hub, filters, join):
    sender = hub.connect()
    packed = b"".join(struct.pack("=II", *pair) for pair in filters)
    program = (
        "s = socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW); s.bind(('vcan0',))\n"
        f"s.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, {packed!r})\n"
        f"s.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_JOIN_FILTERS, {int(join)})\n"
        "end = socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW); end.bind(('vcan0',))\n"
        "print('ready', flush=True)\n"
        "while end.recv(16)[:4] != b'\\xfe\\7\\0\\0': pass\n"
        "s.setblocking(False); got = []\n"
        "try:\n"
        "    while True: got.append(struct.unpack('=I', s.recv(16)[:4])[0])\n"
        "except BlockingIOError: print(got)\n"
    )
    with tool(hub, WITH_CAN, SCRIPTS / "python", "-c", "import socket, struct\n" + program) as listener:
        wait_until(lambda: "ready" in listener.text(), "a listener")
        for can_id in SENT:
            sender.send(classic(can_id))
            sender.send(fd(can_id))  # not received, as CAN_RAW_FD_FRAMES is off
        sender.send(classic(0x20000004, bytes(8)))  # not received either, as it is an error frame
        sender.send(classic(MARKER))
        text = listener.wait().splitlines()[-1]
    expected = [can_id for can_id in [*SENT, MARKER] if kernel_accepts(can_id, filters, join)]
    assert json.loads(text) == expected


def test_error_frames_are_filtered_by_class(hub):
    """A socket receives only the error classes it asked for. Option 2 is CAN_RAW_ERR_FILTER, for which Python has no
    constant."""
    sender = hub.connect()
    program = (
        "s = socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW); s.bind(('vcan0',))\n"
        "s.setsockopt(socket.SOL_CAN_RAW, 2, 0x40)\n"
        "print('ready', flush=True)\n"
        "print(*(f'{p.hex()} {a}' for p, a in (s.recvfrom(16), s.recvfrom(16))), sep=chr(10))\n"
    )
    with tool(hub, WITH_CAN, SCRIPTS / "python", "-u", "-c", "import socket\n" + program) as listener:
        wait_until(lambda: "ready" in listener.text(), "a listener")
        for can_id in (0x20000004, 0x20000040, MARKER):
            sender.send(classic(can_id))
        lines = listener.wait().splitlines()[-2:]
    assert lines == [f"{classic(can_id).hex()} ('vcan0',)" for can_id in (0x20000040, MARKER)]


# ---- through socketcand


def shown(hub: Hub, sender, started: Tool, packets: list[bytes], pattern: str) -> None:
    """Sends the packets repeatedly until the tool's output matches the pattern. They must be repeated, because nothing
    shows when the tool is ready to receive."""

    def is_shown() -> bool:
        for packet in packets:
            sender.send(packet)
        return re.search(pattern, started.text()) is not None

    wait_until(is_shown, f"{pattern} in the output of {started.process.args[0]}")


def test_python_cans_logger(hub, without_listeners):
    sender = hub.connect()
    with tool(hub, SCRIPTS / "can_logger", *tap(hub)) as logger:
        shown(hub, sender, logger, [fd(MARKER, bytes(range(64)))], "ID: +7fe .*DL: 64 +00 01 02 .* 3f")


def test_python_cans_logger_writes_what_was_sent(hub, without_listeners, tmp_path):
    sender = hub.connect()
    frames = logged(without_listeners)[:3000]
    file = tmp_path / "with_listeners.log"
    with tool(hub, SCRIPTS / "can_logger", "-f", file, *tap(hub)) as logger:
        wait_until(lambda: sender.send(classic(MARKER)) and file.exists() and file.stat().st_size > 0, "a log")
        for frame_id, data in frames:
            sender.send(fd(frame_id, data))
        sender.send(classic(0x7FD))
        wait_until(lambda: sender.send(classic(0x7FD)) and " 7FD#" in file.read_text(), "the end")
        logger.process.terminate()
        logger.process.wait(PATIENCE_S)
    assert [frame for frame in frames_in(file.read_text()) if frame[0] < 0x7FD] == frames


def test_python_cans_viewer(hub):
    sender = hub.connect()
    with tool(hub, SCRIPTS / "can_viewer", *tap(hub), terminal=True) as viewer:
        shown(hub, sender, viewer, [classic(0x123, b"\xde\xad\xbe\xef")], r"0x123.*DE AD BE EF")


def test_cantools_monitor_decodes(hub, without_listeners):
    sender = hub.connect()
    dbc = Path(__file__).parents[1] / "host_tools" / "comanip" / "comanip.dbc"
    status = DBC.get_message_by_name("FirmwareStatus")
    frame = next(frame for frame in reversed(logged(without_listeners)) if frame[0] == status.frame_id)
    expected = status.decode(frame[1])
    with tool(hub, SCRIPTS / "cantools", "monitor", dbc, *tap(hub), terminal=True) as monitor:
        shown(
            hub,
            sender,
            monitor,
            [fd(*frame)],
            rf"FirmwareStatus\((?:.|\n)*mode: {expected['mode']}(?:.|\n)*reason: {expected['reason']}",
        )


def test_python_can_sends_through_socketcand(hub):
    listener = hub.connect()
    with can.Bus("vcan0", interface="socketcand", host="127.0.0.1", port=hub.port) as bus:
        bus.send(can.Message(arbitration_id=0x7FF, data=bytes(range(48)), is_fd=True, is_extended_id=False))
        bus.send(can.Message(arbitration_id=0x1ABCDEF0, data=b"\x01"))
        bus.send(can.Message(arbitration_id=0x0, is_extended_id=False))
        packet = listener.recv(100)
        assert packet[:5] + packet[8:] == fd(0x7FF, bytes(range(48)))[:5] + fd(0x7FF, bytes(range(48)))[8:]
        assert listener.recv(100) == classic(CAN_EFF_FLAG | 0x1ABCDEF0, b"\x01")
        assert listener.recv(100) == classic(0x0)
