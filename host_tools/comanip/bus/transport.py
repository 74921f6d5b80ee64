"""Messages on either bus: on CAN FD a message is one frame; on classic CAN the compiled core takes it apart and puts it
together, as in the firmware (``firmware/protocol/can_transport.h``). A message is a Frame in the layout that it has on CAN FD.
"""

from __future__ import annotations

import random
from collections import defaultdict
from enum import Enum

from comanip import native
from comanip.bus.frame import COUNTERS, Frame, classic_parts, database, is_classic, protected


class Profile(str, Enum):
    """Of a bus."""

    FD = "fd"
    CLASSIC = "classic"

    def message(self, name: str):
        """The DBC's for this bus; on classic CAN its first part."""
        parts = classic_parts(name) if self is Profile.CLASSIC else []
        return database().get_message_by_name(parts[0] if parts else name)


def profile_of(frame: Frame) -> Profile | None:
    """Of the bus that carries it; None: the frame does not tell."""
    if frame.message is None:
        return None
    if is_classic(frame.name):
        return Profile.CLASSIC
    return Profile.FD if classic_parts(frame.name) else None


class Sender:
    """The counters of one sender, each begun anywhere: a receiver takes a first repetition for one."""

    def __init__(self, profile: Profile):
        self._profile = profile
        self._counter: dict[str, int] = defaultdict(lambda: random.randrange(COUNTERS))
        if profile is Profile.CLASSIC:
            self._ffi, self._lib = native.load()
            self._state = self._ffi.new("transport_sender_t *")
            self._lib.transport_sender_init(self._state, self._lib.CAN_PROFILE_CLASSIC, self._lib.ARM_MAX_JOINTS)
            for kind in range(self._lib.FRAME_KIND_COUNT):
                self._state.counters.counter[kind] = random.randrange(COUNTERS)

    def frames(self, name: str, signals: dict) -> list[tuple[int, bytes]]:
        """Id and data of the message's frames. Signals out of their range raise ValueError."""
        self._counter[name] = (self._counter[name] + 1) % COUNTERS
        frame_id = database().get_message_by_name(name).frame_id
        data = protected(name, signals, self._counter[name])
        if self._profile is Profile.FD:
            return [(frame_id, data)]
        message = self._ffi.new("can_frame_t *", {"id": frame_id, "length": len(data), "data": data.ljust(64, b"\0")})
        parts = self._ffi.new("can_frame_t[]", self._lib.TRANSPORT_MAX_FRAMES)
        count = self._lib.outbox_frames(self._state, message, parts)
        if count == 0:
            raise ValueError(f"{name}: a value that classic CAN cannot carry")
        return [(parts[i].id, bytes(self._ffi.buffer(parts[i].data, parts[i].length))) for i in range(count)]


class Receiver:
    """Whole messages out of the frames of a bus of either profile. JointCmd, whose parts are as many as the arm's joints,
    is not among those of classic CAN."""

    def __init__(self):
        self._state = None

    def _load(self) -> None:
        self._ffi, self._lib = native.load()
        self._state = self._ffi.new("transport_receiver_t *")
        kinds = (1 << self._lib.FRAME_KIND_COUNT) - 1 - (1 << self._lib.FRAME_JOINT_CMD)
        self._lib.transport_receiver_init(self._state, self._lib.CAN_PROFILE_CLASSIC, self._lib.ARM_MAX_JOINTS, kinds)

    def message(self, frame: Frame) -> Frame | None:
        """The message that this frame completes. Frames of CAN FD come back as they are."""
        if not is_classic(frame.name):
            return frame
        if self._state is None:
            self._load()
        ffi, lib = self._ffi, self._lib
        wire = ffi.new("can_frame_t *", {"timestamp_us": frame.t_us % 2**32, "id": frame.frame_id, "length": len(frame.data), "data": frame.data.ljust(64, b"\0")})  # fmt: skip
        kind = ffi.new("frame_kind_t *")
        if lib.transport_receive(self._state, wire, kind) != lib.PROTOCOL_OK:
            return None
        return frame._replace(frame_id=wire.id, data=bytes(ffi.buffer(wire.data, wire.length)))
