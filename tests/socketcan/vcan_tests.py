"""Firmware and plant on the kernel's SocketCAN, observed with unmodified standard tools: candump, canplayer,
cansniffer, cangen and python-can. `make test-socketcan` runs this file in user-mode Linux."""

from __future__ import annotations

import contextlib
import json
import os
import pty
import re
import select
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import can
import pytest
from bus_log import DBC, FD_MESSAGES
from comanip_command import call
from e2e import p05
from live import ATTEMPTS, CAN_FRAME, FIRMWARE, REPOSITORY, SLOW, Bus, Seen, is_authentic
from test_bus_log import LoggedFrame
from test_two_processes import PLAIN, begin, run_to_end

CANTOOLS = Path(sys.executable).parent / "cantools"
LINE = re.compile(r"\((\d+)\.(\d{6})\) (\w+) ([0-7][0-9A-F]{2})#(?:#([0-9A-F]))?((?:[0-9A-F]{2})*)(?: [RT])?")
FDF = 4  # CANFD_FDF, a flag that newer kernels set in each CAN FD frame and older kernels do not
TO_FIRMWARE = {message.frame_id for message in FD_MESSAGES if "Firmware" in message.receivers}
FOREIGN_ID = 0x7A5
ERROR_FLAG = 0x20000000  # linux/can.h, linux/can/error.h
ERROR_CONTROLLER, ERROR_BUS_OFF, ERROR_RESTARTED = 0x004, 0x040, 0x100
TX_PASSIVE = 0x20


def read_log(path: Path, fd: bool = True) -> list[LoggedFrame]:
    frames = []
    for line in path.read_text().splitlines():
        seconds, microseconds, _, frame_id, flags, data = LINE.fullmatch(line).groups()
        assert int(flags, 16) & ~FDF == 1 if fd else flags is None, "every CAN FD frame switches the bit rate"
        frames.append(LoggedFrame(10**6 * int(seconds) + int(microseconds), int(frame_id, 16), bytes.fromhex(data)))
    return frames


def time_scale(session: Path) -> int:
    return json.loads((session / "plant" / "summary.json").read_text())["real_time"]["slow"]


def payload(frames: list[LoggedFrame]) -> list[tuple[int, bytes]]:
    return [(frame.frame_id, frame.data) for frame in frames]


def listeners(interface: str) -> int:
    """Returns the number of sockets that receive all frames of the interface."""
    lines = Path("/proc/net/can/rcvlist_all").read_text().splitlines()
    return sum(line.split()[0] == interface for line in lines if line.strip())


def wait_for_listeners(interface: str, count: int) -> None:
    deadline = time.monotonic() + 60
    while listeners(interface) < count:
        assert time.monotonic() < deadline, f"{interface}: {listeners(interface)} listeners, expected {count}"
        time.sleep(0.05)


@contextlib.contextmanager
def watched_by_cansniffer(interface: str) -> Iterator[bytearray]:
    """Runs cansniffer and yields its screen output, which grows while cansniffer runs. The version in can-utils 2020
    supports classic frames only."""
    master, slave = pty.openpty()
    others = listeners(interface)
    sniffer = subprocess.Popen(["cansniffer", interface], stdin=slave, stdout=slave, stderr=slave)
    os.close(slave)
    wait_for_listeners(interface, others + 1)
    shown, over = bytearray(), threading.Event()

    def read() -> None:
        while not over.is_set():
            if select.select([master], [], [], 0.2)[0]:
                shown.extend(os.read(master, 4096))

    reader = threading.Thread(target=read)
    reader.start()
    try:
        yield shown
    finally:
        over.set()
        reader.join()
        sniffer.kill()
        sniffer.wait()
        os.close(master)


def wait_until_written(*files: Path) -> None:
    """Waits until the files have not grown for two seconds, because the listeners that write them may lag by many
    frames on a busy machine."""
    sizes, since_s, deadline_s = None, time.monotonic(), time.monotonic() + 120
    while time.monotonic() - since_s < 2:
        assert time.monotonic() < deadline_s, f"{files} keep growing: {sizes}"
        time.sleep(0.2)
        now = [file.stat().st_size for file in files]
        if now != sizes:
            sizes, since_s = now, time.monotonic()


def record_run(bus: Bus, *logger_options: str) -> int:
    """Runs plant and firmware while candump and python-can's logger listen. These listeners start before the firmware
    boots and end after the plant. Returns the exit status of the plant."""
    others = listeners(bus.interface)
    with open(bus.folder / "candump.log", "w") as log:
        candump = subprocess.Popen(["candump", "-L", bus.interface], stdout=log)
        logger = bus.start(
            [sys.executable, "-m", "can.logger", "-i", "socketcan", "-c", bus.interface, *logger_options, "-f",
             bus.folder / "python.log"],
            "logger",
        )  # fmt: skip
        wait_for_listeners(bus.interface, others + 2)
        status = run_to_end(bus, 2.5)
        wait_until_written(bus.folder / "candump.log", bus.folder / "python.log")
        for process in (candump, logger):
            process.send_signal(signal.SIGINT)
            process.wait()
    return status


@pytest.fixture(scope="module")
def session(tmp_path_factory) -> Path:
    for attempt in range(ATTEMPTS):
        folder = tmp_path_factory.mktemp("session")
        with Bus(folder, SLOW << attempt) as bus:
            status = record_run(bus, "--fd")
        if status == 0:
            break
    assert status == 0, bus.output("plant.out") + bus.output("plant.err")
    return folder


# ---- what was on the bus


def test_candump_and_the_plants_log_are_the_same(session):
    """candump's log and the plant's log contain the same frames in the same order. The timestamps are the
    kernel's in both logs; the plant divides them by the factor of its slowed clock."""
    dumped, logged = read_log(session / "candump.log"), read_log(session / "plant" / "bus.log")
    assert len(logged) > 15_000
    assert payload(dumped)[: len(logged)] == payload(logged)
    assert [frame.t_us // time_scale(session) for frame in dumped[: len(logged)]] == [frame.t_us for frame in logged]


def test_python_can_logs_the_same(session):
    dumped, logged = read_log(session / "candump.log"), read_log(session / "python.log")
    assert payload(logged) == payload(dumped)
    assert max(abs(a.t_us - b.t_us) for a, b in zip(logged, dumped, strict=True)) <= 1  # python-can has float times


def test_cantools_decodes_candumps_log(session):
    with open(session / "candump.log") as log:
        done = subprocess.run(
            [CANTOOLS, "decode", "--single-line", REPOSITORY / "host_tools" / "comanip" / "comanip.dbc"],
            stdin=log, capture_output=True, text=True, check=True,
        )  # fmt: skip
    names = re.findall(r":: (\w+)\([^\n]*\)$", done.stdout, re.MULTILINE)
    assert names == [DBC.get_message_by_frame_id(frame.frame_id).name for frame in read_log(session / "candump.log")]


def test_every_frame_is_protected(session):
    last: dict[int, int] = {}
    for frame in read_log(session / "candump.log"):
        message = DBC.get_message_by_frame_id(frame.frame_id)
        data_id = message.dbc.attributes.get("E2EDataId")
        if data_id is not None:
            assert p05.e2e_p05_check(frame.data, data_id.value), message.name
            assert frame.frame_id not in last or frame.data[2] == (last[frame.frame_id] + 1) % 256, message.name
            last[frame.frame_id] = frame.data[2]
        else:
            assert message.name == "FirmwareHeartbeat"


def test_candumps_log_replays_byte_for_byte(session):
    replayed = call("replay", session / "candump.log")
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr


def test_canplayer_plays_it_again(session):
    """canplayer sends the log to a second bus at the recorded pace, and candump receives the same frames on that
    bus."""
    part = (session / "candump.log").read_text().splitlines(keepends=True)[:2000]
    recorded, again = session / "part.log", session / "again.log"
    recorded.write_text("".join(part))
    with open(again, "w") as log:
        candump = subprocess.Popen(["candump", "-L", "-n", str(len(part)), "-T", "20000", "vcan1"], stdout=log)
    deadline = time.monotonic() + 60
    while "vcan1" not in Path("/proc/net/can/rcvlist_all").read_text():
        assert time.monotonic() < deadline
        time.sleep(0.05)
    subprocess.run(["canplayer", "-I", recorded, "vcan1=vcan0"], check=True)
    candump.wait()
    assert payload(read_log(again)) == payload(read_log(recorded))


# ---- the firmware's socket


@pytest.fixture
def alone(tmp_path):
    """Runs the firmware without a plant, so that the firmware waits for the drives."""
    with Bus(tmp_path) as bus:
        firmware = bus.firmware()
        bus.wait_mode("idle")
        yield bus, firmware


def stop(bus: Bus, firmware: subprocess.Popen) -> str:
    firmware.send_signal(signal.SIGTERM)
    assert firmware.wait() == 0
    return bus.output("firmware.out")


def test_the_kernel_filters_for_the_firmware(alone):
    """The firmware's filter list consists of the ids given in the DBC, and other frames do not reach the firmware."""
    bus, firmware = alone
    lines = Path("/proc/net/can/rcvlist_sff").read_text().splitlines()
    ids = {int(line.split()[1], 16) for line in lines if line.split()[:1] == ["vcan0"]}
    assert ids == TO_FIRMWARE
    subprocess.run(["cangen", "vcan0", "-I", f"{FOREIGN_ID:x}", "-L", "8", "-n", "200", "-g", "1"], check=True)
    assert bus.command("select") == "accepted"
    output = stop(bus, firmware)
    assert re.search(r"(\d+) frames received", output)[1] == "1", output
    bus.wait(lambda: sum(frame.frame_id == FOREIGN_ID for frame in bus.frames) == 200, "cangen's frames")


def test_fd_and_classic_frames_are_received(alone):
    """A command in a classic frame is accepted like one in an FD frame, because end-to-end protection covers only the
    data."""
    bus, firmware = alone
    assert bus.command("select") == "accepted"
    message = DBC.get_message_by_name("OperatorCommand")
    data = bytearray(message.encode({"e2e_crc": 0, "e2e_counter": 7, "command": "stop", "sequence": 77, "task": 0}))
    p05.e2e_p05_protect(data, message.dbc.attributes["E2EDataId"].value, increment_counter=False)
    with can.Bus(interface="socketcan", channel="vcan0", fd=True) as python_bus:
        python_bus.send(can.Message(arbitration_id=message.frame_id, data=data, is_extended_id=False, is_fd=False))
        answers = []
        deadline = time.monotonic() + 60
        while not answers and time.monotonic() < deadline:
            received = python_bus.recv(1)
            if received is not None and received.arbitration_id == DBC.get_message_by_name("CommandAck").frame_id:
                answers.append(DBC.decode_message(received.arbitration_id, bytes(received.data)))
    assert (answers[0]["sequence"], str(answers[0]["result"])) == (77, "accepted")
    assert re.search(r"(\d+) frames received", stop(bus, firmware))[1] == "2"


def test_remote_and_extended_frames_are_ignored(alone):
    bus, firmware = alone
    command_id = DBC.get_message_by_name("OperatorCommand").frame_id
    bus.send_packet(CAN_FRAME.pack(command_id | socket.CAN_RTR_FLAG, 8, 0, 0, 0, bytes(8)))
    bus.send_packet(CAN_FRAME.pack(command_id | socket.CAN_EFF_FLAG, 8, 0, 0, 0, bytes(8)))
    assert bus.command("select") == "accepted"
    assert re.search(r"(\d+) frames received", stop(bus, firmware))[1] == "1"


def test_error_frames_are_reported(alone):
    """A vcan bus never reports errors, but a frame that is sent with the error flag is received as an error frame."""
    bus, firmware = alone
    for classes, controller in ((ERROR_CONTROLLER, TX_PASSIVE), (ERROR_BUS_OFF, 0), (ERROR_RESTARTED, 0)):
        bus.send_packet(CAN_FRAME.pack(ERROR_FLAG | classes, 8, 0, 0, 0, bytes([0, controller]) + bytes(6)))
    bus.wait(lambda: "restarted" in bus.output("firmware.err"), "the report")
    stop(bus, firmware)
    output = bus.output("firmware.err")
    for line in (r"error-passive: .*", r"bus-off: .*", r"the controller was restarted", r"3 error frames",
                 r"1 times error-passive", r"1 times bus-off", r"1 restarts"):  # fmt: skip
        assert len(re.findall(rf"^comanip-firmware: vcan0: {line}$", output, re.MULTILINE)) == 1, (line, output)


def test_an_interface_that_goes_down_and_comes_back(alone):
    bus, firmware = alone
    subprocess.run(["ip", "link", "set", "vcan0", "down"], check=True)
    try:
        bus.wait(lambda: "vcan0: lost: Network is down" in bus.output("firmware.err"), "the report")
    finally:
        subprocess.run(["ip", "link", "set", "vcan0", "up"], check=True)
    start = len(bus.frames)
    bus.wait(lambda: "vcan0: back" in bus.output("firmware.err"), "the return")
    bus.wait(lambda: bus.since(start, "JointCmd"), "commands again")
    stop(bus, firmware)
    assert "1 times without the bus" in bus.output("firmware.err")


def test_the_systems_clock_is_set(tmp_path):
    """When the system's clock is set back by 1000 s, the firmware's clock continues, and poses are not considered 1000
    s old."""
    step_s = 1000
    with Bus(tmp_path) as bus:
        begin(bus, str(PLAIN), "--duration", 20)
        bus.wait_mode("ready", "cooperating")
        before_us = bus.since(0, "TickTrace")[-1].decode()["now_us"]
        time.clock_settime(time.CLOCK_REALTIME, time.time() - step_s)
        try:
            bus.wait(lambda: "the system's clock was set: -" in bus.output("firmware.err"), "the report")
            bus.statuses_for(0.04)
            start = len(bus.frames)
            bus.statuses_for(0.04)
            ticks = [frame.decode() for frame in bus.since(start, "TickTrace")]
        finally:
            time.clock_settime(time.CLOCK_REALTIME, time.time() + step_s)
        since_us = [(tick["now_us"] - before_us) % 2**32 for tick in ticks]
        assert all(0 < t_us < 1e6 * step_s / bus.slow / 2 for t_us in since_us)
        assert min(tick["hand_age_us"] for tick in ticks) < 1e6


def test_a_bus_without_fd_is_refused():
    done = subprocess.run([FIRMWARE, "--can", "classic0"], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 2
    assert done.stderr == (
        "comanip-firmware: classic0: MTU 16, expected 72: CAN FD is switched off (ip link set classic0 mtu 72; a real "
        "controller: ip link set classic0 type can fd on; a bus without FD: --profile classic)\n"
    )


# ---- classic CAN, on an interface without FD


@pytest.fixture(scope="module")
def classic_session(tmp_path_factory) -> tuple[Path, bytes]:
    """Returns the folder of a session, and cansniffer's screen output during the session."""
    for attempt in range(ATTEMPTS):
        folder = tmp_path_factory.mktemp("classic")
        with Bus(folder, SLOW << attempt, "classic", "classic0") as bus, watched_by_cansniffer("classic0") as screen:
            status = record_run(bus)
        if status == 0:
            break
    assert status == 0, bus.output("plant.out") + bus.output("plant.err")
    return folder, bytes(screen)


def test_classic_candump_python_can_and_the_plants_log_are_the_same(classic_session):
    folder, _ = classic_session
    dumped, logged, python = (read_log(folder / n, fd=False) for n in ("candump.log", "plant/bus.log", "python.log"))
    assert len(logged) > 2.5 * 8 * 250, f"{len(logged)} frames: fewer than the four joints' commands and states"
    assert payload(dumped)[: len(logged)] == payload(logged)
    assert payload(python) == payload(dumped)


def test_every_classic_frame_is_protected(classic_session):
    for frame in read_log(classic_session[0] / "candump.log", fd=False):
        assert is_authentic(Seen(0, frame.frame_id, frame.data)) is not False


def test_the_classic_log_replays_byte_for_byte(classic_session):
    replayed = call("replay", classic_session[0] / "candump.log")
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr


def test_cansniffer_shows_the_firmwares_classic_frames(classic_session):
    shown = classic_session[1].upper()
    for name in ("ClassicFirmwareStatus", "ClassicJointState0", "ClassicHandPosition"):
        assert f"{DBC.get_message_by_name(name).frame_id:X}".encode() in shown, shown[-500:]


def test_cansniffer_shows_what_changes(alone):
    """cansniffer shows cangen's classic frames alongside the firmware's."""
    with watched_by_cansniffer("vcan0") as shown:
        cangen = subprocess.Popen(["cangen", "vcan0", "-I", f"{FOREIGN_ID:x}", "-L", "8", "-D", "i", "-g", "20"])
        deadline = time.monotonic() + 60
        while f"{FOREIGN_ID:X}".encode() not in shown.upper() and time.monotonic() < deadline:
            time.sleep(0.2)
        cangen.kill()
        cangen.wait()
    assert f"{FOREIGN_ID:X}".encode() in shown.upper(), shown[-500:]
