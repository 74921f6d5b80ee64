"""Runs the C core on a python-can `virtual` bus, in its own thread, with drives and optionally a tracker. The live
commands of `comanip` are tested on this bus. The core ticks as fast as it can, not in real time."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import can
from comanip._core import ffi
from controller_bench import Bench
from simulation import PATIENCE_S

CHANNEL = "live-firmware"
INBOX_FRAMES = 8  # maximum number of frames read from the bus per tick


class LiveFirmware(threading.Thread):
    """The thread that runs the firmware. `deaf` is the number of frames that the firmware ignores before it processes
    the first one. If `mute` is set, the firmware receives frames but sends none."""

    def __init__(self, has_tracker: bool = True):
        super().__init__(daemon=True)
        self.bench = Bench()
        if not has_tracker:
            self.bench.hand = None
        self.deaf, self.mute = 0, False
        self.received: list[can.Message] = []
        self._bus = can.Bus(interface="virtual", channel=CHANNEL, fd=True)
        self._over = threading.Event()

    def run(self) -> None:
        while not self._over.is_set():
            for _ in range(INBOX_FRAMES):
                message = self._bus.recv(0.0005)
                if message is None:
                    break
                self._take(message)
            self.bench.tick()
            for frame_id, data in self.bench.sent:
                if not self.mute:
                    self._bus.send(can.Message(arbitration_id=frame_id, data=data, is_extended_id=False, is_fd=True))

    def _take(self, message: can.Message) -> None:
        self.received.append(message)
        if self.deaf > 0:
            self.deaf -= 1
            return
        frame = ffi.new("can_frame_t *", {"id": message.arbitration_id, "length": len(message.data)})
        ffi.memmove(frame.data, bytes(message.data), len(message.data))
        self.bench.raw.append(frame)

    def wait_for_mode(self, mode: int) -> None:
        deadline_s = time.monotonic() + PATIENCE_S
        while self.bench.controller.supervisor.mode != mode:
            assert time.monotonic() < deadline_s, f"mode is {self.bench.controller.supervisor.mode}, expected {mode}"
            time.sleep(0.01)

    def end(self) -> None:
        self._over.set()
        self.join()
        self._bus.shutdown()


@contextmanager
def firmware(has_tracker: bool = True) -> Iterator[LiveFirmware]:
    live = LiveFirmware(has_tracker)
    live.bench.tick(60)  # long enough to include the boot announcement
    live.start()
    try:
        yield live
    finally:
        live.end()
