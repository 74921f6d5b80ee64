"""Runs firmware and plant as two processes on one bus. If COMANIP_TEST_CAN names a CAN interface of the kernel (as in
tests/socketcan), the bus is that interface; otherwise it is the test's own hub. The tests read and write SocketCAN
structures themselves and decode frames with cantools, so that they do not rely on the code under test."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import struct
import subprocess
import threading
import time
from dataclasses import dataclass
from pathlib import Path

from bus_log import DBC
from e2e import p02, p05
from simulation import PATIENCE_S

REPOSITORY = Path(__file__).resolve().parents[1]
FIRMWARE = REPOSITORY / "build" / "linux" / "comanip-firmware"
PLANT = REPOSITORY / "build" / "linux" / "comanip-plant"
HUB = REPOSITORY / "build" / "host" / "comanip-hub"
INTERFACE = os.environ.get("COMANIP_TEST_CAN", "vcan0")
SLOW = int(os.environ.get("COMANIP_TEST_SLOW", "5"))  # slows time down: the machine is not real-time
# At SLOW = 5 the firmware's watchdog expires after 50 ms, and a virtual machine may pause a processor for longer. At
# SLOWER it expires after 100 ms.
SLOWER = 2 * SLOW
ATTEMPTS = 3  # per test: a busy machine may pause one of the processes and so make a run fail
CAN_FRAME = struct.Struct("<IBBBB8s")  # linux/can.h: id, length, padding or flags, data
CANFD_FRAME = struct.Struct("<IBBBB64s")
CANFD_BRS = 1


def has_kernel_can() -> bool:
    return "COMANIP_TEST_CAN" in os.environ


@dataclass(frozen=True)
class Seen:
    """A frame seen on the bus. `t_s`: reception time by this process's clock, divided by the time scale."""

    t_s: float
    frame_id: int
    data: bytes

    @property
    def name(self) -> str:
        return DBC.get_message_by_frame_id(self.frame_id).name

    def decode(self) -> dict:
        return DBC.decode_message(self.frame_id, self.data)


def packet(frame_id: int, data: bytes) -> bytes:
    return CANFD_FRAME.pack(frame_id, len(data), CANFD_BRS, 0, 0, data)


def is_authentic(frame: Seen) -> bool | None:
    """Checks a frame's protection with the package autosar-e2e. Returns None for a frame without protection."""
    data_id = DBC.get_message_by_frame_id(frame.frame_id).dbc.attributes.get("E2EDataId")
    if data_id is None:
        return None
    if not frame.name.startswith("Classic"):
        return p05.e2e_p05_check(frame.data, data_id.value)
    return p02.e2e_p02_check(
        frame.data, bytes((data_id.value + 16 * n) % 256 for n in range(16)), length=len(frame.data)
    )


class Bus:
    """A bus for the processes, with a tap: a connection that records all frames. This is a context manager, which stops
    all the processes that it started when the context ends."""

    def __init__(self, folder: Path, slow: int = SLOW, profile: str = "fd", interface: str = INTERFACE):
        self.folder, self.slow, self.profile, self.interface = folder, slow, profile, interface
        self.environment = os.environ | {"COMANIP_HUB_DIR": str(folder)}
        self.frames: list[Seen] = []
        self._processes: list[subprocess.Popen] = []
        self._counter = 100  # sequence number of the test's operator frames
        self._over = threading.Event()

    def __enter__(self) -> Bus:
        if has_kernel_can():
            self._tap = socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
            self._tap.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FD_FRAMES, 1)
            self._tap.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
            self._tap.bind((self.interface,))
        else:
            path = self.folder / self.interface
            path.unlink(missing_ok=True)
            self.hub = self.start([HUB, "--bus", self.interface, "--socketcand", "off"], "hub")
            self._tap = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            # Between bind() and listen(), the socket exists and refuses connections.
            self.wait(lambda: self._tap.connect_ex(str(path)) == 0, "the hub's socket")
        self._tap.settimeout(0.2)
        self._reader = threading.Thread(target=self._read)
        self._reader.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._reader.join()
        for process in reversed(self._processes):
            with contextlib.suppress(ProcessLookupError):
                process.send_signal(signal.SIGCONT)
            process.kill()
            process.wait()
        self._tap.close()

    def _read(self) -> None:
        while not self._over.is_set():
            try:
                data = self._tap.recv(CANFD_FRAME.size)
                if not data:
                    return  # the hub has ended
            except TimeoutError:
                continue
            except OSError as error:
                if self._over.is_set() or not has_kernel_can():
                    return
                assert error.errno, error  # the interface is down, and the test will bring it up again
                time.sleep(0.01)
                continue
            layout = CANFD_FRAME if len(data) == CANFD_FRAME.size else CAN_FRAME
            frame_id, length, _, _, _, payload = layout.unpack(data)
            self.frames.append(Seen(time.monotonic() / self.slow, frame_id, payload[:length]))

    # ---- processes

    def start(self, command: list, name: str) -> subprocess.Popen:
        """Starts a process whose output goes to NAME.out and NAME.err in the folder."""
        with open(self.folder / f"{name}.out", "a") as out, open(self.folder / f"{name}.err", "a") as err:
            process = subprocess.Popen(
                [str(part) for part in command], stdout=out, stderr=err, stdin=subprocess.DEVNULL, env=self.environment
            )
        self._processes.append(process)
        return process

    def firmware(self, name: str = "firmware", program: Path = FIRMWARE, *arguments: object) -> subprocess.Popen:
        options = ["--can", self.interface, "--slow", self.slow, "--profile", self.profile]
        return self.start([program, *options, *arguments], name)

    def plant(self, *arguments: object, name: str = "plant") -> subprocess.Popen:
        options = ["--can", self.interface, "--slow", self.slow, "--profile", self.profile, "--out", self.folder / name]
        return self.start([PLANT, *options, *arguments], name)

    def output(self, file: str) -> str:
        return (self.folder / file).read_text()

    # ---- time

    def wait(self, condition, what: str) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < deadline, f"timed out after {PATIENCE_S} s waiting for: {what}; {self._story()}"
            assert not self._has_panicked(), f"a process panicked while waiting for: {what}; {self._story()}"
            time.sleep(0.02)

    def _has_panicked(self) -> bool:
        return any(": panic: " in path.read_text() for path in self.folder.glob("*.err"))

    def _story(self) -> str:
        files = sorted([*self.folder.glob("*.err"), *self.folder.glob("*.out")])
        return "; ".join(f"{path.name}: {path.read_text()[-800:]!r}" for path in files)

    # ---- frames

    def message(self, name: str):
        """Returns the DBC message that carries the message `name` on the bus. If classic CAN splits the message,
        returns the last part."""
        if self.profile == "fd" or name == "FirmwareHeartbeat":
            return DBC.get_message_by_name(name)
        return DBC.get_message_by_name("Classic" + {"HandPose": "HandRotation"}.get(name, name))

    def since(self, start: int, name: str) -> list[Seen]:
        frame_id = self.message(name).frame_id
        return [frame for frame in self.frames[start:] if frame.frame_id == frame_id]

    def commands(self, start: int, joints: int) -> list[dict]:
        """Returns the signals of each JointCmd. On classic CAN, a command is complete with the last joint's part."""
        if self.profile == "fd":
            return [frame.decode() for frame in self.since(start, "JointCmd")]
        found, parts = [], {}
        first = self.message("JointCmd0").frame_id
        for frame in self.frames[start:]:
            joint = frame.frame_id - first
            if 0 <= joint < joints:
                signals = frame.decode()
                parts |= {f"velocity_{joint}_radps": signals["velocity_radps"], f"mode_{joint}": signals["mode"]}
                if joint == joints - 1 and len(parts) == 2 * joints:
                    found.append(parts)
                    parts = {}
        return found

    def status(self) -> tuple[str, str]:
        """Returns mode and reason from the latest FirmwareStatus."""
        frame_id = self.message("FirmwareStatus").frame_id
        for i in range(len(self.frames) - 1, -1, -1):
            if self.frames[i].frame_id == frame_id:
                status = self.frames[i].decode()
                return str(status["mode"]), str(status["reason"])
        return "", ""

    def wait_mode(self, *modes: str, start: int = 0) -> None:
        """Waits until the latest FirmwareStatus reports one of the given modes. A status among the first `start` frames
        does not count."""
        self.wait(lambda: self.since(start, "FirmwareStatus") and self.status()[0] in modes, f"mode {modes}")

    def statuses_for(self, duration_s: float) -> list[tuple[str, str]]:
        """Returns mode and reason from each FirmwareStatus received in the next `duration_s` seconds."""
        start, count = len(self.frames), round(1000 * duration_s / self.message("FirmwareStatus").cycle_time)
        self.wait(lambda: len(self.since(start, "FirmwareStatus")) >= count, f"{count} FirmwareStatus frames")
        output = [frame.decode() for frame in self.since(start, "FirmwareStatus")]
        return [(str(status["mode"]), str(status["reason"])) for status in output]

    def send_packet(self, data: bytes) -> None:
        self._tap.send(data)

    def command(self, command: str) -> str:
        """Sends an OperatorCommand once a second until the firmware acknowledges it. Returns the result."""
        sent_s, start = 0.0, len(self.frames)

        def answers() -> list[dict]:
            nonlocal sent_s
            if time.monotonic() - sent_s > 1:
                sent_s = time.monotonic()
                self._send_command(command)
            acks = [frame.decode() for frame in self.since(start, "CommandAck")]
            return [ack for ack in acks if ack["sequence"] == self._counter]

        found: list[dict] = []
        self.wait(lambda: found.extend(answers()) or found, f"acknowledgement of {command}")
        return str(found[0]["result"])

    def _send_command(self, command: str) -> None:
        message = self.message("OperatorCommand")
        self._counter = (self._counter + 1) % 256
        data_id, is_fd = message.dbc.attributes["E2EDataId"].value, self.profile == "fd"
        counter = self._counter % (256 if is_fd else 16)
        values = {"e2e_crc": 0, "e2e_counter": counter, "command": command, "sequence": self._counter, "task": 0}
        data = bytearray(message.encode(values))
        if is_fd:
            p05.e2e_p05_protect(data, data_id, increment_counter=False)
            self.send_packet(packet(message.frame_id, bytes(data)))
        else:
            p02.e2e_p02_protect(data, bytes((data_id + 16 * n) % 256 for n in range(16)), increment_counter=False)
            self.send_packet(CAN_FRAME.pack(message.frame_id, len(data), 0, 0, 0, bytes(data)))
