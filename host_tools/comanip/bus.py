"""A live CAN bus through python-can: frames in, protected messages out."""

from __future__ import annotations

import logging
import random
import socket
import time
from collections import defaultdict
from dataclasses import dataclass

import can

from comanip.errors import ToolError
from comanip.frame import COUNTERS, Frame, database, protected
from comanip.logs import from_message

CONNECT_S = 2.0


@dataclass(frozen=True)
class BusAddress:
    """What python-can calls interface and channel; host and port are socketcand's."""

    interface: str = "socketcan"
    channel: str = "vcan0"
    host: str = "127.0.0.1"
    port: int = 29536

    def __str__(self) -> str:
        return f"{self.interface} {self.channel}"


class LiveBus:
    """A context. Sends with the counters of one sender, each begun anywhere: a receiver takes a first repetition for one."""

    def __init__(self, bus: can.BusABC, address: BusAddress):
        self._bus, self._address = bus, address
        self._counter: dict[str, int] = defaultdict(lambda: random.randrange(COUNTERS))

    def __enter__(self) -> LiveBus:
        return self

    def __exit__(self, *_: object) -> None:
        self._bus.shutdown()

    def send(self, name: str, signals: dict) -> None:
        """ToolError if the bus does not take it."""
        self._counter[name] = (self._counter[name] + 1) % COUNTERS
        message = database().get_message_by_name(name)
        data = protected(name, signals, self._counter[name])
        frame = can.Message(
            arbitration_id=message.frame_id, data=data, is_extended_id=False, is_fd=True, bitrate_switch=True
        )
        try:
            self._bus.send(frame, timeout=0.1)
        except (can.CanError, OSError) as error:
            raise ToolError(f"{self._address}: {name} cannot be sent: {error}") from error

    def receive(self, timeout_s: float) -> Frame | None:
        """The next frame; None if there is none in time. ToolError if the bus is gone."""
        try:
            message = self._bus.recv(timeout_s)
        except (can.CanError, OSError) as error:
            raise ToolError(f"{self._address}: cannot be read any more: {error}") from error
        return None if message is None else from_message(message)

    def receive_until(self, deadline_s: float) -> Frame | None:
        """By time.monotonic()."""
        return self.receive(max(0.0, deadline_s - time.monotonic()))


def open_bus(address: BusAddress) -> LiveBus:
    """ToolError if python-can cannot open it."""
    logging.getLogger("can").addHandler(logging.NullHandler())  # what matters comes as an exception
    options = {"host": address.host, "port": address.port} if address.interface == "socketcand" else {}
    try:
        if options:  # python-can itself tries for ten seconds
            socket.create_connection((address.host, address.port), CONNECT_S).close()
        bus = can.Bus(interface=address.interface, channel=address.channel, fd=True, **options)
    except (can.CanError, OSError, ImportError, ValueError, TypeError, NotImplementedError) as error:
        raise ToolError(
            f"{address}: cannot be opened: {error}; `comanip doctor` tells which buses this machine has"
        ) from error
    return LiveBus(bus, address)
