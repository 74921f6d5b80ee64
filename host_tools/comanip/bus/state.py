"""Computes the state of a bus from its frames: rates, ages, load, errors and latest signals. All times are on the
frames' clock."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

from comanip.bus.frame import E2EChecker, Frame, Verdict, decode, messages
from comanip.bus.frame_length import FD_LENGTHS, BitRates, longest
from comanip.bus.transport import Receiver

WINDOW_US = 1_000_000
FD_RATES = BitRates(1_000_000, 5_000_000)
CLASSIC_RATES = BitRates(1_000_000)


@dataclass
class IdState:
    """The state of one id. times_us: times of the frames within the last WINDOW_US."""

    last: Frame
    count: int = 0
    refused: int = 0  # number of frames that failed the end-to-end check
    verdict: Verdict = Verdict(None, "")
    times_us: deque[int] = field(default_factory=deque)

    def rate_hz(self, now_us: int) -> float:
        _forget(self.times_us, now_us)
        return len(self.times_us) * 1e6 / WINDOW_US


def _forget(times: deque, now_us: int) -> None:
    while times and (times[0] if isinstance(times[0], int) else times[0][0]) <= now_us - WINDOW_US:
        times.popleft()


class BusState:
    def __init__(self):
        self.ids: dict[tuple[int, bool], IdState] = {}
        self.now_us = 0
        self.frames = self.error_frames = 0
        self._checker, self._receiver = E2EChecker(), Receiver()
        self._messages: dict[str, Frame] = {}
        self._busy: deque[tuple[int, int]] = deque()  # (time, duration in ns)
        self._busy_ns = 0

    def feed(self, frame: Frame) -> None:
        self.now_us = max(self.now_us, frame.t_us)
        if frame.error:
            self.error_frames += 1
            return
        self.frames += 1
        state = self.ids.setdefault((frame.frame_id, frame.extended), IdState(frame))
        state.last, state.count = frame, state.count + 1
        state.times_us.append(frame.t_us)
        state.verdict = self._checker.check(frame)
        state.refused += state.verdict.ok is False
        message = self._receiver.message(frame)
        if message is not None and message.message is not None:
            self._messages[message.name] = message
        duration_ns = frame_duration_ns(frame)
        self._busy.append((frame.t_us, duration_ns))
        self._busy_ns += duration_ns

    def load_percent(self, now_us: int | None = None) -> float:
        """Returns an upper bound on the bus load at 1 Mbit/s, with 5 Mbit/s in the data phase of CAN FD. Each frame
        counts as the longest frame with its id and length."""
        now_us = self.now_us if now_us is None else now_us
        while self._busy and self._busy[0][0] <= now_us - WINDOW_US:
            self._busy_ns -= self._busy.popleft()[1]
        return 100 * self._busy_ns / (1000 * WINDOW_US)

    def rate_hz(self, now_us: int | None = None) -> float:
        now_us = self.now_us if now_us is None else now_us
        return sum(state.rate_hz(now_us) for state in self.ids.values())

    def of(self, name: str) -> IdState | None:
        """Returns the state of this message's id, or None if no frame with this id has been received."""
        frame_id = next(i for i, message in messages().items() if message.name == name)
        return self.ids.get((frame_id, False))

    def signals(self, name: str) -> dict:
        """Returns the signals of the latest message with this name, in either profile, or {} if none has been
        received."""
        message = self._messages.get(name)
        return (decode(message) or {}) if message else {}


def frame_duration_ns(frame: Frame) -> int:
    """Returns the duration of the longest frame with this id and length. An extended id counts as a standard id plus 20
    bits."""
    # Uses the DBC because socketcand does not report whether a frame is CAN FD.
    classic = not frame.fd and len(frame.data) <= 8 and not (frame.message and frame.message.is_fd)
    length = len(frame.data) if classic else next((n for n in FD_LENGTHS if n >= len(frame.data)), FD_LENGTHS[-1])
    duration_ns = longest(
        frame.frame_id & 0x7FF, 0 if frame.remote else length, CLASSIC_RATES if classic else FD_RATES
    ).duration_ns
    return duration_ns + 20_000 * frame.extended
