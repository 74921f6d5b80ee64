"""Sends and receives messages with end-to-end protection on a live bus, CAN FD or classic, through python-can."""

from __future__ import annotations

import logging
import socket
import time
from dataclasses import dataclass

import can

from comanip.bus.frame import Frame
from comanip.bus.logs import from_message
from comanip.bus.transport import Profile, Receiver, Sender, profile_of
from comanip.errors import ToolError

CONNECT_S = 2.0
# Time for which to listen for traffic that reveals the profile. FirmwareStatus is sent every 2 ms (CAN FD) or 8 ms
# (classic CAN); the hub's socketcand starts to forward frames after 300 ms.
LISTEN_S = 0.8
WAITING_FRAMES = 100


@dataclass(frozen=True)
class BusAddress:
    """The address of a bus. interface, channel: as python-can names them. host, port: used by the interface socketcand
    only."""

    interface: str = "socketcan"
    channel: str = "vcan0"
    host: str = "127.0.0.1"
    port: int = 29536
    profile: Profile | None = None  # None: detected from the traffic, or CAN FD if there is no traffic

    def __str__(self) -> str:
        return f"{self.interface} {self.channel}"


class LiveBus:
    """An open bus, which can be used as a context manager."""

    def __init__(self, bus: can.BusABC, address: BusAddress):
        self._bus, self._address = bus, address
        self.profile = address.profile or self._heard_profile()
        self._sender, self._receiver = Sender(self.profile), Receiver()

    def _heard_profile(self) -> Profile:
        deadline_s = time.monotonic() + LISTEN_S
        while (left_s := deadline_s - time.monotonic()) > 0:
            frame = self.receive_frame(left_s)
            if frame is not None and profile_of(frame) is not None:
                return profile_of(frame)
        return Profile.FD

    def __enter__(self) -> LiveBus:
        return self

    def __exit__(self, *_: object) -> None:
        self._bus.shutdown()

    def send(self, name: str, signals: dict) -> None:
        """Sends a message. Raises ToolError if the bus does not accept it."""
        is_fd = self.profile is Profile.FD
        try:
            frames = self._sender.frames(name, signals)
        except ValueError as error:
            raise ToolError(f"{self._address}: {error}") from error
        for frame_id, data in frames:
            frame = can.Message(
                arbitration_id=frame_id, data=data, is_extended_id=False, is_fd=is_fd, bitrate_switch=is_fd
            )
            try:
                self._bus.send(frame, timeout=0.1)
            except (can.CanError, OSError) as error:
                raise ToolError(f"{self._address}: {name} cannot be sent: {error}") from error

    def receive(self, timeout_s: float) -> Frame | None:
        """Returns the next message, or None after the timeout. Up to WAITING_FRAMES frames that are already waiting at
        the timeout are still read, because they may complete a message. Raises ToolError if the bus can no longer be
        read."""
        deadline_s, waiting = time.monotonic() + timeout_s, WAITING_FRAMES
        while True:
            frame = self.receive_frame(max(0.0, deadline_s - time.monotonic()))
            message = self._receiver.message(frame) if frame else None
            if message is not None:
                return message
            if time.monotonic() >= deadline_s:
                waiting -= 1
                if frame is None or waiting == 0:
                    return None

    def receive_frame(self, timeout_s: float) -> Frame | None:
        """Returns the next frame without checking it, or None after the timeout. Some interfaces of python-can return
        None before the timeout."""
        try:
            message = self._bus.recv(timeout_s)
        except (can.CanError, OSError) as error:
            raise ToolError(f"{self._address}: can no longer be read: {error}") from error
        return None if message is None else from_message(message)

    def receive_until(self, deadline_s: float) -> Frame | None:
        """Works like receive(), but with a deadline by time.monotonic() instead of a timeout."""
        return self.receive(max(0.0, deadline_s - time.monotonic()))


def open_bus(address: BusAddress) -> LiveBus:
    """Opens the bus. Raises ToolError if python-can cannot open it."""
    logging.getLogger("can").addHandler(logging.NullHandler())  # no log on stderr: errors are raised instead
    options = {"host": address.host, "port": address.port} if address.interface == "socketcand" else {}
    try:
        if options:  # test the connection first, because python-can would try for ten seconds
            socket.create_connection((address.host, address.port), CONNECT_S).close()
        bus = can.Bus(
            interface=address.interface, channel=address.channel, fd=address.profile is not Profile.CLASSIC, **options
        )
    except (can.CanError, OSError, ImportError, ValueError, TypeError, NotImplementedError) as error:
        raise ToolError(
            f"{address}: cannot be opened: {error}; `comanip doctor` lists the buses of this machine"
        ) from error
    return LiveBus(bus, address)
