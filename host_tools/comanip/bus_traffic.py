"""The traffic of the bus as streams for ``response_time``: CAN FD from the DBC, classic CAN as a set of its own.

What the DBC does not say is assumed here and printed by ``make bus-report``: how often frames on events come, how long
the firmware computes, how fast a drive answers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cantools

from comanip.frame_length import BitRates, longest, shortest
from comanip.response_time import Stream

DBC_PATH = Path(__file__).with_name("comanip.dbc")
MAX_JOINTS = 8
NS_PER_MS, NS_PER_US = 1_000_000, 1_000
FD_TICK_MS, CLASSIC_TICK_MS = 1, 4
EVENT_TICKS = 2
EVENT_DEADLINE_MS = 20
BOOT_MS = 1000
COMPUTING_US = 50
ANSWER_US = 20
TICK = "tick"
REQUEST, ACKNOWLEDGEMENT, BOOT = "request", "acknowledgement", "boot"
ASSUMPTIONS = (
    "One operator, who waits for the acknowledgement, which takes a tick: requests are at least one tick apart, in the long run"
    f" {EVENT_TICKS}. Each of their frames is to arrive within {EVENT_DEADLINE_MS} ms.",
    f"The firmware queues its frames together, 0 to {COMPUTING_US} us after its tick.",
    f"Drives and gripper queue an answer {ANSWER_US} us after the end of the command.",
    "Each node offers its lowest id first. No errors, hence no repetitions.",
    "At boot: FirmwareIdentity, and one ParameterValue a tick until all are told.",
    "Classic is not in the DBC yet: assumed are 250 Hz, a command and a state of 8 bytes a joint, the pose in two frames at 125 Hz,"
    " larger messages in parts that are sent one a tick, no trace.",
)


@dataclass(frozen=True)
class Frame:
    """Frames of one kind: every `period_ms`, or on events, in the long run one in a period. `batch`, `one_of` and
    `answers` as in Stream."""

    name: str
    identifier: int
    length: int
    period_ms: int
    batch: str | None = None
    one_of: str | None = None
    answers: str | None = None

    @property
    def is_cyclic(self) -> bool:
        return self.one_of is None and not self.name.endswith((", answer", ", boot"))

    @property
    def deadline_ms(self) -> int:
        return self.period_ms if self.is_cyclic else EVENT_DEADLINE_MS

    def stream(self, rates: BitRates) -> Stream:
        computing_ns = COMPUTING_US * NS_PER_US if self.batch else 0
        early_ns = self.period_ms * NS_PER_MS // EVENT_TICKS if self.one_of else 0
        return Stream(
            self.name,
            self.identifier,
            longest(self.identifier, self.length, rates).duration_ns,
            shortest(self.identifier, self.length, rates).duration_ns,
            self.period_ms * NS_PER_MS,
            jitter_ns=computing_ns + early_ns,
            batch=self.batch,
            one_of=self.one_of,
            answers=self.answers,
            answer_delay_ns=ANSWER_US * NS_PER_US if self.answers else 0,
        )


def fd_frames(joints: int) -> list[Frame]:
    """All of the DBC but what comes at boot only; of the joint states those of an arm with so many joints."""
    frames = []
    for message in cantools.database.load_file(DBC_PATH).messages:
        is_joint_state = message.name.startswith("JointState")
        is_absent = is_joint_state and int(message.name.removeprefix("JointState")) >= joints
        if is_absent or message.name == "FirmwareIdentity":
            continue
        batch = TICK if message.senders == ["Firmware"] else None
        one_of = None if message.cycle_time else ACKNOWLEDGEMENT if batch else REQUEST
        answers = "JointCmd" if is_joint_state else None
        period_ms = message.cycle_time or EVENT_TICKS * FD_TICK_MS
        frames.append(Frame(message.name, message.frame_id, message.length, period_ms, batch, one_of, answers))
    return [*frames, gripper_answer(EVENT_TICKS * FD_TICK_MS)]


def fd_boot_frames() -> list[Frame]:
    """What comes at boot, beside all others."""
    return [
        Frame("FirmwareIdentity, boot", 0x013, 16, BOOT_MS, batch=TICK),
        Frame("ParameterValue, boot", 0x012, 12, FD_TICK_MS, batch=TICK),
    ]


def classic_frames(joints: int) -> list[Frame]:
    """A TrackerStatus is in two parts, so one of them comes every 10 ms."""
    numbers, event_ms = range(joints), EVENT_TICKS * CLASSIC_TICK_MS
    return [
        Frame("FirmwareStatus", 0x010, 8, 8, TICK),
        Frame("CommandAck", 0x011, 8, event_ms, TICK, ACKNOWLEDGEMENT),
        Frame("ParameterValue", 0x012, 8, event_ms, TICK, ACKNOWLEDGEMENT),
        *(Frame(f"JointCmd{joint}", 0x050 + joint, 8, CLASSIC_TICK_MS, TICK) for joint in numbers),
        Frame("Clearance", 0x110, 8, 8),
        Frame("HandPosition", 0x120, 8, 8),
        Frame("HandRotation", 0x121, 8, 8),
        *(Frame(f"JointState{joint}", 0x180 + joint, 8, CLASSIC_TICK_MS, answers=f"JointCmd{joint}") for joint in numbers),
        Frame("GripperState", 0x190, 8, 20),
        Frame("OperatorCommand", 0x200, 8, event_ms, one_of=REQUEST),
        Frame("TaskDefine", 0x201, 8, event_ms, one_of=REQUEST),
        Frame("ParameterAccess", 0x202, 8, event_ms, one_of=REQUEST),
        Frame("GripperCommand", 0x210, 8, event_ms, one_of=REQUEST),
        Frame("TrackerStatus", 0x320, 8, 10),
        Frame("FirmwareHeartbeat", 0x701, 1, 100, TICK),
        gripper_answer(event_ms),
    ]


def classic_boot_frames() -> list[Frame]:
    return [
        Frame("FirmwareIdentity, boot", 0x013, 8, BOOT_MS, batch=TICK),
        Frame("ParameterValue, boot", 0x012, 8, CLASSIC_TICK_MS, batch=TICK),
    ]


def gripper_answer(event_ms: int) -> Frame:
    """GripperState comes in its period, and after each command."""
    return Frame("GripperState, answer", 0x190, 8, event_ms, answers="GripperCommand")


def streams(frames: Sequence[Frame], rates: BitRates) -> list[Stream]:
    return [frame.stream(rates) for frame in frames]
