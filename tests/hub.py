"""Provides a hub for a single test, raw SocketCAN packets, and a way to run listening tools such as candump, each in
its own process."""

from __future__ import annotations

import contextlib
import fcntl
import os
import pty
import re
import select
import shutil
import signal
import socket
import struct
import subprocess
import tempfile
import termios
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from simulation import PATIENCE_S, REPOSITORY

HUB = REPOSITORY / "build" / "host" / "comanip-hub"
WITH_CAN = REPOSITORY / "build" / "host" / "with-can"
SCRIPTS = REPOSITORY / ".venv" / "bin"
CAN_MTU, CANFD_MTU = 16, 72  # <linux/can.h>
CAN_EFF_FLAG = 0x80000000
CANFD_BRS = 1


def classic(can_id: int, data: bytes = b"", length: int | None = None) -> bytes:
    """Returns a packed struct can_frame."""
    return struct.pack("=IB3x8s", can_id, len(data) if length is None else length, data)


def fd(can_id: int, data: bytes = b"", length: int | None = None) -> bytes:
    """Returns a packed struct canfd_frame with the bit rate switch set."""
    return struct.pack("=IBB2x64s", can_id, len(data) if length is None else length, CANFD_BRS, data)


def wait_until(condition: Callable[[], object], what: str) -> object:
    """Waits until the condition returns a true value, and returns that value."""
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        value = condition()
        if value:
            return value
        time.sleep(0.01)
    raise AssertionError(f"timed out after {PATIENCE_S} s waiting for: {what}")


def everything_in(file) -> str:
    """Returns the contents of a file without moving the file offset, because the process that writes the file uses the
    same offset."""
    return os.pread(file.fileno(), os.fstat(file.fileno()).st_size, 0).decode(errors="replace")


class Hub:
    """A running hub. `environment` lets the tools find it; `port` is the TCP port of the hub's socketcand, or None if
    socketcand is off."""

    def __init__(self, *arguments: str, bus: str = "vcan0", folder: Path | None = None):
        # The default folder has a short path, because a socket path is limited to 107 bytes.
        self._own = None if folder else tempfile.mkdtemp(prefix="comanip-test-")
        self.folder = Path(folder or self._own)
        self.bus, self.path = bus, self.folder / bus
        self.environment = {**os.environ, "COMANIP_HUB_DIR": str(self.folder)}
        self.complaints = tempfile.TemporaryFile()
        command = [str(HUB), "--bus", bus, *(arguments or ("--socketcand", "off"))]
        self.process = subprocess.Popen(
            command, env=self.environment, stdout=subprocess.PIPE, stderr=self.complaints, text=True
        )
        output = []
        for line in self.process.stdout:
            output.append(line)
            if " at /" in line:
                break
        port = re.search(r"socketcand at 127\.0\.0\.1:(\d+)", "".join(output))
        self.port = int(port[1]) if port else None

    def stderr(self) -> str:
        return everything_in(self.complaints)

    def connect(self, suffix: str = "") -> socket.socket:
        client = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        client.settimeout(PATIENCE_S)
        client.connect(f"{self.path}{suffix}")
        return client

    def clients(self) -> int:
        """Returns how many connections to the hub's Unix socket the kernel lists. An accepted connection is listed with
        the path of the hub's socket and the state "connected" (03)."""
        lines = Path("/proc/net/unix").read_text().splitlines()
        return sum(line.endswith(f" {self.path}") and line.split()[5] == "03" for line in lines)

    def wait_for_clients(self, count: int) -> None:
        wait_until(lambda: self.clients() >= count, f"{count} clients of {self.path}")

    def stop(self) -> int:
        """Stops the hub as Ctrl-C would, so that it first delivers all queued frames."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        return self.process.wait(PATIENCE_S)

    def close(self) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self.process.stdout.close()
        self.complaints.close()
        if self._own:
            shutil.rmtree(self._own, ignore_errors=True)


@contextlib.contextmanager
def running(*arguments: str, **places) -> Iterator[Hub]:
    """Runs a hub, by default without socketcand."""
    hub = Hub(*arguments, **places)
    try:
        yield hub
    finally:
        hub.close()


class Tool:
    """A program that writes to a file or a terminal until the hub or the test stops it."""

    def __init__(self, hub: Hub, *command: object, terminal: bool = False):
        self.output = tempfile.TemporaryFile()
        self.environment = {**hub.environment, "TERM": "xterm", "PYTHONUNBUFFERED": "1"}
        self._master = None
        stdin, stdout = subprocess.DEVNULL, self.output
        if terminal:
            self._master, slave = pty.openpty()
            fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 60, 200, 0, 0))
            stdin = stdout = slave
        self.process = subprocess.Popen(
            [str(part) for part in command], env=self.environment, stdin=stdin, stdout=stdout, stderr=subprocess.STDOUT,
            start_new_session=True,
        )  # fmt: skip
        if terminal:
            os.close(slave)

    def text(self) -> str:
        """Returns all output so far."""
        while self._master is not None and select.select([self._master], [], [], 0)[0]:
            try:
                self.output.write(os.read(self._master, 65536))
            except OSError:  # the program has ended
                break
        self.output.flush()
        return everything_in(self.output)

    def require_running(self) -> None:
        """Fails if the program has ended, because it would send nothing more. The message contains the program's
        output."""
        status = self.process.poll()
        assert status is None, f"{self.process.args[0]} has ended with exit status {status}: {self.text()}"

    def wait(self) -> str:
        self.process.wait(PATIENCE_S)
        return self.text()

    def close(self) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self.output.close()
        if self._master is not None:
            os.close(self._master)


@contextlib.contextmanager
def tool(hub: Hub, *command: object, terminal: bool = False) -> Iterator[Tool]:
    started = Tool(hub, *command, terminal=terminal)
    try:
        yield started
    finally:
        started.close()
