"""Acts as the tracker on the bus: sends a HandPose for each pose and, when the caller asks for it, a TrackerStatus.
Both have end-to-end protection."""

from __future__ import annotations

import statistics
import time
from collections import deque

from comanip.bus.frame import database
from comanip.bus.live import LiveBus
from comanip.tracker.pose_lines import Pose

CLOCK_US = 2**32  # the tracker's clock wraps
COUNT = 2**16
PERIOD_US = (1_000, 100_000)  # range that the firmware accepts
INTERVALS = 50  # number of intervals whose median is the estimated period


def status_period_s(bus: LiveBus) -> float:
    return bus.profile.message("TrackerStatus").cycle_time / 1000


class TrackerPublisher:
    """Publishes poses. rate_hz: rate of the tracker; None: estimated from the poses' timestamps. clock: returns the
    time for poses without a timestamp."""

    def __init__(self, bus: LiveBus, rate_hz: float | None = None, clock=time.monotonic):
        self._bus, self._clock = bus, clock
        self._period_us = round(1e6 / rate_hz) if rate_hz else None
        self._intervals_us: deque[int] = deque(maxlen=INTERVALS)
        self._last_us: int | None = None
        self.sent = self.lost = self.range_errors = 0

    def publish(self, pose: Pose) -> None:
        """Sends the pose. A pose that exceeds the signals' range is sent as invalid and counted as a range error."""
        t_us = round(1e6 * (self._clock() if pose.t_s is None else pose.t_s))
        if self._last_us is not None and t_us - self._last_us > 0:
            self._intervals_us.append(t_us - self._last_us)
        self._last_us = t_us
        quaternion = (min(max(component, -1.0), 1.0) for component in pose.quaternion)  # rounding errors may exceed 1
        signals = dict(zip(("x_m", "y_m", "z_m"), pose.position_m)) | dict(zip(("qw", "qx", "qy", "qz"), quaternion))
        positions, quaternions = self._bus.profile.message("HandPose"), database().get_message_by_name("HandPose")
        ranges = {
            name: (positions if name.endswith("_m") else quaternions).get_signal_by_name(name) for name in signals
        }
        if all(_fits(ranges[name], value) for name, value in signals.items()):
            self._bus.send("HandPose", {"t_us": t_us % CLOCK_US, "valid": 1} | signals)
            self.sent += 1
        else:
            self.range_errors += 1
            self._lose(t_us)

    def lose(self) -> None:
        """Reports a lost sample by sending an invalid pose."""
        self._lose(round(1e6 * self._clock()) if self._last_us is None else self._last_us + self.period_us)

    def _lose(self, t_us: int) -> None:
        self.lost += 1
        nothing = dict.fromkeys(("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"), 0)
        self._bus.send("HandPose", {"t_us": t_us % CLOCK_US, "valid": 0} | nothing)

    @property
    def period_us(self) -> int:
        """The sample period, rounded to 10 us, which is the resolution in TrackerStatus."""
        period_us = self._period_us
        if period_us is None:
            default_us = 1000 * self._bus.profile.message("HandPose").cycle_time
            period_us = round(statistics.median(self._intervals_us)) if self._intervals_us else default_us
        return 10 * round(min(max(period_us, PERIOD_US[0]), PERIOD_US[1]) / 10)

    def publish_status(self) -> None:
        now_us = round(1e6 * self._clock()) if self._last_us is None else self._last_us
        self._bus.send(
            "TrackerStatus",
            {"t_us": now_us % CLOCK_US, "period_us": self.period_us, "latency_us": 0, "fault": 0,
             "lost_samples": self.lost % COUNT, "range_errors": self.range_errors % COUNT},
        )  # fmt: skip


def _fits(signal, value: float) -> bool:
    low = signal.minimum if signal.minimum is not None else float("-inf")
    high = signal.maximum if signal.maximum is not None else float("inf")
    return low <= value <= high
