"""Replays a recorded bus: the C core, fed with the frames of a log, must send what the firmware had sent.

Each TickTrace tells the time of its tick and which frames it had read; ``_binding/replay.h`` says how. The log must begin
at the firmware's boot, and come from a firmware of the same build hash.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from comanip import native
from comanip.bus.frame import Frame, data_id, database, decode, has_right_crc, is_classic, messages
from comanip.bus.transport import Profile, Receiver
from comanip.errors import ToolError

_CAN_FRAME = struct.Struct("<IHB?64s")  # can_frame_t
_FOREIGN_ID = 0xFFFF  # no standard data frame
FIRMWARE = "Firmware"


@dataclass(frozen=True)
class Difference:
    """The first one. `recorded`: the log's frame; `sent`: the payload that the firmware sends there, if it sends one."""

    what: str
    place: int  # in the log, from 0
    recorded: Frame
    sent: Frame | None = None


@dataclass(frozen=True)
class Report:
    ticks: int
    boots: int
    fed: int  # frames that the firmware had read
    compared: int  # frames that it had sent
    difference: Difference | None


def _native_log(ffi, frames: Sequence[Frame]):
    """can_frame_t of each, and the object that owns the memory. What is no standard data frame gets a foreign id."""
    offsets = [ffi.offsetof("can_frame_t", name) for name in ("timestamp_us", "id", "length", "fd", "data")]
    if offsets != [0, 4, 6, 7, 8] or ffi.sizeof("can_frame_t") != _CAN_FRAME.size:
        raise AssertionError("can_frame_t has another layout than replay.py thinks")
    pack = _CAN_FRAME.pack
    packed = b"".join(
        pack(0, _FOREIGN_ID if f.extended or f.remote or f.error else f.frame_id, len(f.data), f.fd, f.data)
        for f in frames
    )
    return ffi.from_buffer("can_frame_t[]", packed)


def _first(frames: Sequence[Frame], name: str) -> Frame | None:
    return next((frame for frame in frames if frame.message and frame.name == name), None)


def _identity(frames: Sequence[Frame]) -> dict | None:
    """What the first FirmwareIdentity tells; on classic CAN of the two parts, each of them undamaged. Build hash None: it is
    damaged."""
    receiver = Receiver()
    for frame in frames:
        if frame.message is None or frame.name not in (
            "FirmwareIdentity",
            "ClassicFirmwareBuild",
            "ClassicFirmwareIdentity",
        ):
            continue
        if not is_classic(frame.name) and not has_right_crc(frame):
            return decode(frame) | {"build_hash": None}
        message = receiver.message(frame)
        if message is not None:
            return decode(message)
    return None


def _require_boot(frames: Sequence[Frame], profile: Profile, build_hash: int) -> str:
    """The arm's name. ToolError unless the log begins at the boot of a firmware with this hash. A damaged identity is no
    other build: the replay will come upon it."""
    trace, told = _first(frames, profile.message("TickTrace").name), _identity(frames)
    if trace is None:
        raise ToolError(
            "the log has no TickTrace, expected one each tick: is the parameter `trace` 0, or is this another bus?"
        )
    began = _first(frames, profile.message("FirmwareIdentity").name)
    if began is None or (trace.counter != 0 and has_right_crc(trace)):
        raise ToolError(
            f"the log does not begin at the firmware's boot (its first TickTrace has number {trace.counter}"
            f"{'' if began else ', and there is no FirmwareIdentity'}), expected all frames since then"
        )
    if told is None or told["build_hash"] is None:
        return str(told["arm"]) if told else ""
    if told["build_hash"] != build_hash:
        raise ToolError(
            f"the log comes from the firmware with build hash {told['build_hash']:016x}, this core has {build_hash:016x}: "
            "expected the same; check out and build the revision that recorded it"
        )
    return str(told["arm"])


def _profile(frames: Sequence[Frame]) -> Profile:
    return Profile.CLASSIC if _first(frames, "ClassicTickTrace") and not _first(frames, "TickTrace") else Profile.FD


def _is_damaged(frame: Frame) -> bool:
    return bool(frame.message and data_id(frame.name) and not has_right_crc(frame))


def _first_damaged(frames: Sequence[Frame]) -> int | None:
    """Place of the first frame between other nodes whose CRC is wrong: no replay can tell of it."""
    others = {
        message.frame_id
        for message in database().messages
        if FIRMWARE not in message.senders and FIRMWARE not in message.receivers
    }
    return next((i for i, frame in enumerate(frames) if frame.frame_id in others and _is_damaged(frame)), None)


class Replay:
    """`frames` of a log, from the firmware's boot on. ToolError if they cannot be replayed."""

    def __init__(self, frames: Sequence[Frame]):
        self._ffi, self._lib = native.load()
        self.frames = frames
        ffi, lib = self._ffi, self._lib
        profile = _profile(frames)
        name = _require_boot(frames, profile, lib.replay_build_hash())
        arm = getattr(lib, f"arm_{name}", lib.arm_hoap3_right)  # a damaged name: the replay will come upon it
        by_kind = [messages()[lib.frame_table[kind].id] for kind in range(lib.FRAME_KIND_COUNT)]
        self._log = _native_log(ffi, frames)
        self._stream_of = ffi.new("uint8_t[]", len(frames))
        self._next = ffi.new("uint32_t[]", len(frames))
        self._state = ffi.new("replay_t *")
        self._arm = ffi.addressof(arm)
        lib.replay_init(
            self._state, self._arm, lib.CAN_PROFILE_CLASSIC if profile is Profile.CLASSIC else lib.CAN_PROFILE_FD,
            self._log, len(frames), self._stream_of, self._next,
            [FIRMWARE in message.receivers for message in by_kind], [FIRMWARE in message.senders for message in by_kind],
        )  # fmt: skip

    def run(self, chunk: int = 20_000) -> Iterator[int]:
        """Replays; yields after each chunk how many frames of the log are done."""
        end = chunk
        while self.run_to(end):
            yield min(end, len(self.frames))
            end += chunk

    def run_to(self, place: int) -> bool:
        """Replays what stands before this place in the log. True: there may be more."""
        return bool(self._lib.replay_run(self._state, min(place, len(self.frames))))

    def report(self) -> Report:
        """After all of it was run."""
        self._lib.replay_finish(self._state)
        state = self._state
        return Report(state.ticks, state.boots, state.fed, state.compared, self._difference())

    # ---- the first difference, in words

    def _difference(self) -> Difference | None:
        damaged, found = _first_damaged(self.frames), self._found()
        if damaged is not None and (found is None or damaged < found.place):
            return Difference("damaged: its CRC is wrong; it went past the firmware", damaged, self.frames[damaged])
        return found or self._damaged_at_the_end()

    def _damaged_at_the_end(self) -> Difference | None:
        """After the last tick that the log tells of."""
        for place in range(self._state.former_tick_place, len(self.frames)):
            if _is_damaged(self.frames[place]):
                return Difference(
                    "damaged: its CRC is wrong; the log ends before a tick reads it", place, self.frames[place]
                )
        return None

    def _found(self) -> Difference | None:
        lib, state = self._lib, self._state
        if state.result == lib.REPLAY_EQUAL:
            return None
        recorded = self.frames[state.place]
        if state.result == lib.REPLAY_DIFFERENT:
            return Difference("the firmware sends other bytes", state.place, recorded, self._sent(recorded))
        if state.result == lib.REPLAY_NOT_SENT:
            traced = state.tick_place != lib.REPLAY_NO_FRAME
            what = (
                "the firmware does not send this frame"
                if traced
                else "the trace ends before this frame: the rest cannot be replayed"
            )
            return Difference(what, state.place, recorded)
        if state.result == lib.REPLAY_NOT_IN_LOG:
            sent = self._sent(recorded)
            return Difference(
                f"in this tick the firmware sends a {sent.name} that the log does not have", state.place, recorded, sent
            )
        if state.result == lib.REPLAY_DAMAGED:
            return Difference("damaged: its CRC is wrong, and the firmware had not refused it", state.place, recorded)
        lost = messages()[state.sent.id].name
        return Difference(
            f"this tick had read a {lost} with counter {state.sent.data[0]}, which is not in the log",
            state.place,
            recorded,
        )

    def _sent(self, recorded: Frame) -> Frame:
        sent = self._state.sent
        data = bytes(self._ffi.buffer(sent.data, sent.length))
        return recorded._replace(frame_id=sent.id, data=data, extended=False, remote=False, error=False)
