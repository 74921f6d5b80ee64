"""Converts between messages and the frames of either profile. On CAN FD a message is one frame. On classic CAN the
compiled core splits and reassembles messages, as in the firmware (``firmware/protocol/can_transport.h``). A message is
represented by a Frame in CAN FD layout.
"""

from __future__ import annotations

import random
from collections import defaultdict
from enum import Enum

from comanip import native
from comanip.bus.frame import COUNTERS, Frame, classic_parts, database, is_classic, protected


class Profile(str, Enum):
    """The kind of CAN on a bus."""

    FD = "fd"
    CLASSIC = "classic"

    def message(self, name: str):
        """Returns the DBC's entry for this message in this profile. On classic CAN, returns the entry of the message's
        first part."""
        parts = classic_parts(name) if self is Profile.CLASSIC else []
        return database().get_message_by_name(parts[0] if parts else name)


def profile_of(frame: Frame) -> Profile | None:
    """Returns the profile of a bus that carries this frame, or None if the frame is not specific to a profile."""
    if frame.message is None:
        return None
    if is_classic(frame.name):
        return Profile.CLASSIC
    return Profile.FD if classic_parts(frame.name) else None


class Sender:
    """A sender on the bus, which counts its messages and splits them into frames. The counters start at random values,
    because a receiver could mistake a restart at 0 for a repeated frame."""

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
        """Returns (id, data) of each frame of the message. Raises ValueError if a signal is out of range."""
        self._counter[name] = (self._counter[name] + 1) % COUNTERS
        frame_id = database().get_message_by_name(name).frame_id
        data = protected(name, signals, self._counter[name])
        if self._profile is Profile.FD:
            return [(frame_id, data)]
        message = self._ffi.new("can_frame_t *", {"id": frame_id, "length": len(data), "data": data.ljust(64, b"\0")})
        parts = self._ffi.new("can_frame_t[]", self._lib.TRANSPORT_MAX_FRAMES)
        count = self._lib.outbox_frames(self._state, message, parts)
        if count == 0:
            raise ValueError(f"{name}: a value is out of the range of the frames for classic CAN")
        return [(parts[i].id, bytes(self._ffi.buffer(parts[i].data, parts[i].length))) for i in range(count)]


class Receiver:
    """Reassembles messages from the frames of a bus of either profile. JointCmd on classic CAN is not reassembled,
    because this class does not know the number of joints, which is the number of parts."""

    def __init__(self):
        self._state = None

    def _load(self) -> None:
        self._ffi, self._lib = native.load()
        self._state = self._ffi.new("transport_receiver_t *")
        kinds = (1 << self._lib.FRAME_KIND_COUNT) - 1 - (1 << self._lib.FRAME_JOINT_CMD)
        self._lib.transport_receiver_init(self._state, self._lib.CAN_PROFILE_CLASSIC, self._lib.ARM_MAX_JOINTS, kinds)

    def message(self, frame: Frame) -> Frame | None:
        """Returns the message that this frame completes, or None. Returns a frame unchanged unless it is a part of a
        message on classic CAN."""
        if not is_classic(frame.name):
            return frame
        if self._state is None:
            self._load()
        ffi, lib = self._ffi, self._lib
        payload = {"length": len(frame.data), "data": frame.data.ljust(64, b"\0")}
        wire = ffi.new("can_frame_t *", {"timestamp_us": frame.t_us % 2**32, "id": frame.frame_id, **payload})
        kind = ffi.new("frame_kind_t *")
        if lib.transport_receive(self._state, wire, kind) != lib.PROTOCOL_OK:
            return None
        return frame._replace(frame_id=wire.id, data=bytes(ffi.buffer(wire.data, wire.length)))
