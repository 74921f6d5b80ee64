"""Generates the firmware's input for a run in which an operator changes something every few ticks and waits for each
answer."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np
import oracle
import stimulus
from comanip._core import ffi, lib
from controller_bench import Bench

HAND_M, SWING_M, SWING_RADPS = np.array([0.4, 0.2, 0.1]), 0.12, np.array([2.0, 3.0, 2.5])
TURN_RAD, TURN_RADPS = 0.3, 3.0
STATUS_TICKS = 100
PAUSE_TICKS = (3, 60)
GAP_TICKS = 80  # length of a gap without samples, longer than the tracker timeout


class Operated(Bench):
    """A test bench of the controller, with a hand that moves back and forth.

    ticks_read: the inbox of each tick, as input for runner.c. seen: how often each kind of event has occurred.
    """

    def __init__(self, rng: np.random.Generator):
        super().__init__(prediction=True)
        self._rng, self._gap_until = rng, 0
        self.ticks_read: list[bytes] = []
        self.seen: Counter[str] = Counter()

    def tick(self, count: int = 1) -> None:
        for _ in range(count):
            time_s = 1e-3 * self.ticks
            turned = oracle.rotation([0, 1, 0], np.pi / 2 + TURN_RAD * np.sin(TURN_RADPS * time_s))
            self.hand = (
                None
                if self.ticks < self._gap_until
                else oracle.pose(turned, HAND_M + SWING_M * np.sin(SWING_RADPS * time_s))
            )
            if self.ticks % STATUS_TICKS == 0:
                frame = ffi.new("can_frame_t *")
                lib.tracker_status_pack(
                    ffi.new("tracker_status_t *", {"t_us": self.now_us % 2**32, "period_us": 4000}), frame
                )
                self.requests.append(frame)
            super().tick()
            self.ticks_read.append(stimulus.tick(self.now_us, [self.inbox.frame[i] for i in range(self.inbox.count)]))
            self._count()

    def _count(self) -> None:
        at_limit = lib.joints_at_limit_find(
            self.controller.arm, self.controller.joint_limits_config.at_limit_rad, self.controller.measured_rad
        )
        cooperates = self.mode == lib.MODE_COOPERATING
        self.seen["demand deferred"] += self.controller.demand_deferred
        self.seen["hold"] += self.mode == lib.MODE_HOLD
        self.seen["a joint at its limit"] += cooperates and lib.joints_at_limit_any(at_limit)

    def _stop(self) -> None:
        assert self.command(lib.COMMAND_STOP) == lib.RESULT_ACCEPTED
        self.tick(300)  # time to come to rest from any speed, and to be seen at rest
        measured = self.controller.parameters.value[lib.PARAMETER_LATCH_MEASURED]
        assert self.write(lib.PARAMETER_LATCH_MEASURED, 1 - measured) == lib.RESULT_ACCEPTED

    def _define(self) -> None:
        q_task = self._rng.normal(size=4)
        self.define(q_task=q_task / np.linalg.norm(q_task), blend_s=float(self._rng.choice([0, 0.1])))

    def operate(self) -> None:
        """Performs one random operator action, or starts a gap in the tracker samples."""
        if self.mode == lib.MODE_READY:
            self.seen["start"] += self.command(lib.COMMAND_START) == lib.RESULT_ACCEPTED
            return
        name, act = (
            ("select", lambda: self.command(lib.COMMAND_SELECT, int(self._rng.integers(3)))),
            ("latch", lambda: self.command(lib.COMMAND_LATCH)),
            ("clutch", lambda: self.command(lib.COMMAND_CLUTCH)),
            ("define", self._define),
            ("read", lambda: self.access(lib.PARAMETER_READ, int(self._rng.integers(lib.PARAMETER_COUNT)), 0.0)),
            ("stop", self._stop),
            ("gap", lambda: setattr(self, "_gap_until", self.ticks + GAP_TICKS)),
        )[self._rng.choice(7, p=[0.2, 0.2, 0.2, 0.2, 0.1, 0.05, 0.05])]
        self.seen[name] += 1
        act()


def run(ticks: int, seed: int) -> Operated:
    result = Operated(np.random.default_rng(seed))
    result.until_ready()
    while result.ticks < ticks:
        result.operate()
        result.tick(int(result._rng.integers(*PAUSE_TICKS)))
    return result


def operated(ticks: int, seed: int) -> Iterator[bytes]:
    yield stimulus.boot(lib.CAN_PROFILE_FD)
    yield from run(ticks, seed).ticks_read
