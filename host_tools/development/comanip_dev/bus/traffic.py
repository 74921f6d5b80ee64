"""Derives the traffic on the bus, CAN FD or classic, from the DBC, as streams for ``response_time``.

The DBC does not contain the rate of frames that are sent on events, the computing time of the firmware, or the response
time of the drives. These are assumed here, and ``make bus-report`` prints the assumptions.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from cantools.database.can import Message
from comanip.bus.frame import CLASSIC, classic_parts, database, is_classic
from comanip.bus.frame_length import BitRates, longest, shortest

from comanip_dev.bus.response_time import Stream

NS_PER_MS, NS_PER_US = 1_000_000, 1_000
FD_TICK_MS, CLASSIC_TICK_MS = 1, 4
FD_EVENT_TICKS, CLASSIC_EVENT_TICKS = 2, 1  # average interval between two requests, in ticks
EVENT_DEADLINE_MS = 20
DEFINE_MS = 100
BOOT_MS = 1000
COMPUTING_US = 50
ANSWER_US = 20
TICK = "tick"
REQUEST, ACKNOWLEDGEMENT = "request", "acknowledgement"
BOOT_ONLY = ("FirmwareIdentity", f"{CLASSIC}FirmwareIdentity", f"{CLASSIC}FirmwareBuild")
OTHER_PARTS_OF_A_REQUEST = tuple(CLASSIC + part for part in ("TaskTranslation", "TaskRotation", "TaskInverse"))
ASSUMPTIONS = (
    "There is one operator, who waits one tick for the acknowledgement of each request. Requests are at least one tick"
    f" apart, and {FD_EVENT_TICKS} ticks on average on CAN FD. Each frame of a request or acknowledgement must arrive"
    f" within {EVENT_DEADLINE_MS} ms.",
    f"The firmware queues its frames together, 0 to {COMPUTING_US} us after its tick.",
    f"Drives and gripper queue an answer {ANSWER_US} us after the end of the command.",
    "Each node offers its frame with the lowest id first. There are no errors and therefore no retransmissions.",
    "At boot the firmware sends FirmwareIdentity, and one ParameterValue per tick until it has sent all of them.",
    "On classic CAN drives answer the last joint's command, and a TaskDefine, which has four parts, is sent at most"
    f" once in {DEFINE_MS} ms.",
)


@dataclass(frozen=True)
class Frame:
    """Frames of one kind, sent every period_ms or, if they are sent on events, once per period_ms on average. batch,
    one_of and answers have the same meaning as in Stream."""

    name: str
    identifier: int
    length: int
    period_ms: int
    batch: str | None = None
    one_of: str | None = None
    answers: str | None = None
    early_ms: int = 0  # a frame may be sent this long before its period has elapsed

    @property
    def is_cyclic(self) -> bool:
        return self.one_of is None and not self.name.endswith((", answer", ", boot"))

    @property
    def deadline_ms(self) -> int:
        return self.period_ms if self.is_cyclic else EVENT_DEADLINE_MS

    def stream(self, rates: BitRates) -> Stream:
        computing_ns = COMPUTING_US * NS_PER_US if self.batch else 0
        return Stream(
            self.name,
            self.identifier,
            longest(self.identifier, self.length, rates).duration_ns,
            shortest(self.identifier, self.length, rates).duration_ns,
            self.period_ms * NS_PER_MS,
            jitter_ns=computing_ns + self.early_ms * NS_PER_MS,
            batch=self.batch,
            one_of=self.one_of,
            answers=self.answers,
            answer_delay_ns=ANSWER_US * NS_PER_US if self.answers else 0,
        )


def _number(name: str, kind: str) -> int | None:
    """Returns the number of the joint to which the frame belongs, or None."""
    found = re.fullmatch(rf"(?:{CLASSIC})?{kind}(\d)", name)
    return int(found[1]) if found else None


def _messages(is_for_classic: bool) -> list[Message]:
    """Returns the messages of a profile. A message without parts for classic CAN, such as the heartbeat, is in both
    profiles."""
    return [
        message
        for message in database().messages
        if is_classic(message.name) == is_for_classic or not (is_classic(message.name) or classic_parts(message.name))
    ]


def _frames(joints: int, is_for_classic: bool) -> list[Frame]:
    """Returns all frames for an arm with this number of joints, except those that are sent only at boot."""
    prefix, tick_ms = (CLASSIC, CLASSIC_TICK_MS) if is_for_classic else ("", FD_TICK_MS)
    event_ms = tick_ms * (CLASSIC_EVENT_TICKS if is_for_classic else FD_EVENT_TICKS)
    sync = f"{CLASSIC}JointCmd{joints - 1}" if is_for_classic else "JointCmd"
    frames = []
    for message in _messages(is_for_classic):
        state, command = _number(message.name, "JointState"), _number(message.name, "JointCmd")
        is_absent = max(state or 0, command or 0) >= joints
        if is_absent or message.name in BOOT_ONLY:
            continue
        is_other_part = message.name in OTHER_PARTS_OF_A_REQUEST
        batch = TICK if message.senders == ["Firmware"] else None
        request = f"{REQUEST}, {message.name}" if is_other_part else REQUEST
        one_of = None if message.cycle_time else ACKNOWLEDGEMENT if batch else request
        period_ms = message.cycle_time or (DEFINE_MS if is_other_part else event_ms)
        answers = sync if state is not None else None
        early_ms = event_ms - tick_ms if one_of and not is_other_part else 0
        frames.append(
            Frame(message.name, message.frame_id, message.length, period_ms, batch, one_of, answers, early_ms)
        )
    state = next(frame for frame in frames if frame.name == f"{prefix}GripperState")
    return [
        *frames,
        replace(state, name=f"{state.name}, answer", period_ms=event_ms, answers=f"{prefix}GripperCommand"),
    ]


def _boot_frames(is_for_classic: bool) -> list[Frame]:
    """Returns the frames that are sent only at boot, in addition to all others."""
    tick_ms = CLASSIC_TICK_MS if is_for_classic else FD_TICK_MS
    periods_ms = dict.fromkeys(BOOT_ONLY, BOOT_MS) | dict.fromkeys(
        ("ParameterValue", f"{CLASSIC}ParameterValue"), tick_ms
    )
    return [
        Frame(f"{message.name}, boot", message.frame_id, message.length, periods_ms[message.name], batch=TICK)
        for message in _messages(is_for_classic)
        if message.name in periods_ms
    ]


def fd_frames(joints: int) -> list[Frame]:
    return _frames(joints, is_for_classic=False)


def fd_boot_frames() -> list[Frame]:
    return _boot_frames(is_for_classic=False)


def classic_frames(joints: int) -> list[Frame]:
    return _frames(joints, is_for_classic=True)


def classic_boot_frames() -> list[Frame]:
    return _boot_frames(is_for_classic=True)


def streams(frames: Sequence[Frame], rates: BitRates) -> list[Stream]:
    return [frame.stream(rates) for frame in frames]
