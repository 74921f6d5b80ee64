"""Replays a log of the bus: runs the C core on the recorded input and checks that it sends the recorded frames.

Each TickTrace records the time of a tick and which frames the firmware read in that tick; see ``_binding/replay.h``.
The log must begin at the firmware's boot. It may come from another build, provided that TickTrace and the frames that
the firmware receives have the same layout and meaning in both builds (FirmwareIdentity.trace_version and trace_hash).
Some messages are not compared, and the report lists them. PortStatus is one of them: the DBC marks it as not replayed,
because the log does not contain everything on which it depends. For a log from another build, FirmwareIdentity and the
messages that only one of the two builds sends are not compared either.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from cantools.database.can.message import Message

from comanip import native
from comanip.bus.frame import Frame, data_id, database, decode, decode_raw, has_right_crc, messages
from comanip.bus.transport import Profile
from comanip.errors import ToolError

_CAN_FRAME = struct.Struct("<IHB?64s")  # can_frame_t
_FOREIGN_ID = 0xFFFF  # stands for any frame that is not a standard data frame
FIRMWARE = "Firmware"


@dataclass(frozen=True)
class Difference:
    """The first difference between log and replay. recorded: the frame in the log. sent: the frame that the replayed
    firmware sends instead, if any."""

    what: str
    place: int  # index in the log, from 0
    recorded: Frame
    sent: Frame | None = None


@dataclass(frozen=True)
class Report:
    ticks: int
    boots: int
    fed: int  # number of recorded frames fed to the core
    compared: int  # number of frames from the core that were compared with the log
    difference: Difference | None
    other_build: int | None = None  # hash of the build that recorded the log, if it differs from this core's
    left_out: tuple[str, ...] = ()  # names of the messages that are not compared


def _native_log(ffi, frames: Sequence[Frame]):
    """Returns the frames as an array of can_frame_t. The core ignores frames with the id _FOREIGN_ID, which all frames
    other than standard data frames get."""
    offsets = [ffi.offsetof("can_frame_t", name) for name in ("timestamp_us", "id", "length", "fd", "data")]
    if offsets != [0, 4, 6, 7, 8] or ffi.sizeof("can_frame_t") != _CAN_FRAME.size:
        raise AssertionError("can_frame_t does not have the layout that replay.py expects")
    pack = _CAN_FRAME.pack
    packed = b"".join(
        pack(0, _FOREIGN_ID if f.extended or f.remote or f.error else f.frame_id, len(f.data), f.fd, f.data)
        for f in frames
    )
    return ffi.from_buffer("can_frame_t[]", packed)


def _first(frames: Sequence[Frame], name: str) -> Frame | None:
    return next((frame for frame in frames if frame.message and frame.name == name), None)


IDENTITY = ("FirmwareIdentity", "ClassicFirmwareBuild", "ClassicFirmwareIdentity", "ClassicFirmwareTrace")
BEFORE_TRACE_HASH_BYTES = 16  # length of the earlier FirmwareIdentity, without trace_version and trace_hash
BEFORE_TRACE_HASH = 0xBC992C5D  # trace hash of the firmware that sent the earlier FirmwareIdentity (trace version 1)


@dataclass(frozen=True)
class Identity:
    """The contents of the first FirmwareIdentity in a log. arm: name of the arm. build_hash: None if the frame is
    damaged."""

    arm: str
    build_hash: int | None
    trace_version: int = 1
    trace_hash: int = BEFORE_TRACE_HASH


def _from_signals(signals: dict) -> Identity:
    return Identity(
        str(signals["arm"]), signals["build_hash"], int(signals["trace_version"]), int(signals["trace_hash"])
    )


def _fd_identity(frame: Frame) -> Identity:
    is_short = len(frame.data) == BEFORE_TRACE_HASH_BYTES
    whole = frame._replace(data=frame.data.ljust(frame.message.length, b"\0")) if is_short else frame
    signals = decode(whole) or {"arm": "", "build_hash": None, "trace_version": 0, "trace_hash": 0}
    if not has_right_crc(frame):
        return Identity(str(signals["arm"]), None)
    found = _from_signals(signals)
    return Identity(found.arm, found.build_hash) if is_short else found


def _classic_identity(frames: Sequence[Frame]) -> Identity | None:
    """Combines the parts of the firmware's identity. Returns None if there is no undamaged first or second part. The
    third part may be missing, because earlier firmware did not send it."""
    found: dict[str, dict] = {}
    for frame in frames:
        if frame.message and frame.name in IDENTITY and has_right_crc(frame):
            found.setdefault(frame.name, decode(frame))
        if len(found) == len(IDENTITY) - 1:
            break
    build, identity, trace = (found.get(name) for name in IDENTITY[1:])
    if build is None or identity is None:
        return None
    build_hash = int(identity["build_hash_high"]) << 48 | int(build["build_hash_low"])
    if trace is None:
        return Identity(str(identity["arm"]), build_hash)
    return Identity(str(identity["arm"]), build_hash, int(trace["trace_version"]), int(trace["trace_hash"]))


def _identity(frames: Sequence[Frame], profile: Profile) -> Identity | None:
    """Returns the firmware's identity, or None if the log contains none. On classic CAN a damaged identity also yields
    None."""
    if profile is Profile.CLASSIC:
        return _classic_identity(frames)
    first = _first(frames, "FirmwareIdentity")
    return _fd_identity(first) if first else None


def _require_boot(frames: Sequence[Frame], profile: Profile, lib) -> Identity:
    """Returns the firmware's identity. Raises ToolError unless the log begins at the firmware's boot and was recorded
    with this core's trace version. A damaged identity does not raise ToolError here, because the replay later reports
    the damaged frame as a difference."""
    trace = _first(frames, profile.message("TickTrace").name)
    if trace is None:
        raise ToolError(
            "the log contains no TickTrace, expected one per tick: is the parameter `trace` 0, or is this another bus?"
        )
    began = _first(frames, profile.message("FirmwareIdentity").name)
    if began is None or (has_right_crc(trace) and trace.counter != 0):
        number = trace.counter if has_right_crc(trace) else "unknown"
        raise ToolError(
            f"the log does not begin at the firmware's boot (its first TickTrace has number {number}"
            f"{'' if began else ', and there is no FirmwareIdentity'}), expected all frames since boot"
        )
    told = _identity(frames, profile)
    if told is None or told.build_hash is None:
        return told or Identity("", None)
    own = lib.replay_trace_version(), lib.replay_trace_hash()
    if (told.trace_version, told.trace_hash) != own:
        raise ToolError(
            f"the log has trace version {told.trace_version} (hash {told.trace_hash:08x}, firmware build "
            f"{told.build_hash:016x}), but this core has version {own[0]} (hash {own[1]:08x}, build "
            f"{lib.replay_build_hash():016x}); expected the same; check out and build the revision that recorded it"
        )
    return told


def _announced_parameters(frames: Sequence[Frame], profile: Profile) -> set[int]:
    """Returns the numbers of the parameters that the firmware announces at boot."""
    name = profile.message("ParameterValue").name
    values = (decode_raw(frame) for frame in frames if frame.message and frame.name == name and has_right_crc(frame))
    return {value["parameter"] for value in values if value and value["sequence"] == 0}


def _profile(frames: Sequence[Frame]) -> Profile:
    return Profile.CLASSIC if _first(frames, "ClassicTickTrace") and not _first(frames, "TickTrace") else Profile.FD


def is_replayed(message: Message) -> bool:
    """Returns False for messages that the DBC marks as not replayed, such as PortStatus. The log does not contain
    everything on which such a message depends."""
    attribute = message.dbc.attributes.get("Replayed")
    return attribute is None or bool(attribute.value)


def _is_damaged(frame: Frame) -> bool:
    return bool(frame.message and data_id(frame.name) and not has_right_crc(frame))


def _first_damaged(frames: Sequence[Frame]) -> int | None:
    """Returns the index of the first frame with a wrong CRC among the frames that the replay does not check: frames
    exchanged between other nodes, and messages that are not replayed."""
    others = {
        message.frame_id
        for message in database().messages
        if (FIRMWARE not in message.senders and FIRMWARE not in message.receivers) or not is_replayed(message)
    }
    return next((i for i, frame in enumerate(frames) if frame.frame_id in others and _is_damaged(frame)), None)


class Replay:
    """Replays a log, beginning at the firmware's boot. Raises ToolError if the log cannot be replayed."""

    def __init__(self, frames: Sequence[Frame]):
        self._ffi, self._lib = native.load()
        self.frames = frames
        ffi, lib = self._ffi, self._lib
        profile = _profile(frames)
        identity = _require_boot(frames, profile, lib)
        arm = getattr(
            lib, f"arm_ik_{identity.arm}", lib.arm_ik_hoap3_right
        )  # if the name is damaged, the replay reports the frame that contains it
        self._other_build = None if identity.build_hash in (None, lib.replay_build_hash()) else identity.build_hash
        by_kind = [messages()[lib.frame_table[kind].id] for kind in range(lib.FRAME_KIND_COUNT)]
        self._log = _native_log(ffi, frames)
        self._stream_of = ffi.new("uint8_t[]", len(frames))
        self._next = ffi.new("uint32_t[]", len(frames))
        self._state = ffi.new("replay_t *")
        self._arm = ffi.addressof(arm)
        can_profile = lib.CAN_PROFILE_CLASSIC if profile is Profile.CLASSIC else lib.CAN_PROFILE_FD
        to_firmware = [FIRMWARE in message.receivers for message in by_kind]
        from_firmware = [FIRMWARE in message.senders for message in by_kind]
        log = (self._log, len(frames), self._stream_of, self._next)
        lib.replay_init(self._state, self._arm, can_profile, *log, to_firmware, from_firmware)

        self._leave_out(profile, by_kind)
        if self._other_build is not None:
            announced = _announced_parameters(frames, profile)
            lib.replay_other_build(self._state, [number in announced for number in range(lib.PARAMETER_NUMBERS)])

    def _leave_out(self, profile: Profile, by_kind: Sequence[Message]) -> None:
        """Excludes from the comparison the messages that are not replayed. If another build recorded the log, also
        excludes the messages that only one of the two builds sends, and FirmwareIdentity because of its build hash."""
        in_log = {frame.frame_id for frame in self.frames if frame.message}
        is_other = self._other_build is not None
        left_out, self._left_out = [], ()
        for message in by_kind:
            is_in_log = profile.message(message.name).frame_id in in_log
            only_one_sends = is_other and (message.name == "FirmwareIdentity" or not is_in_log)
            is_out = FIRMWARE in message.senders and (only_one_sends or not is_replayed(message))
            left_out.append(is_out)
            if is_out and (is_in_log or is_other):
                self._left_out += (message.name,)
        self._lib.replay_leave_out(self._state, left_out)

    def run(self, chunk: int = 20_000) -> Iterator[int]:
        """Replays the whole log. After each chunk, yields the number of frames replayed so far."""
        end = chunk
        while self.run_to(end):
            yield min(end, len(self.frames))
            end += chunk

    def run_to(self, place: int) -> bool:
        """Replays the log up to this index. Returns True if there may be more to replay."""
        return bool(self._lib.replay_run(self._state, min(place, len(self.frames))))

    def report(self) -> Report:
        """Completes the replay after run() and returns the report."""
        self._lib.replay_finish(self._state)
        state = self._state
        return Report(
            state.ticks, state.boots, state.fed, state.compared, self._difference(), self._other_build, self._left_out
        )

    # ---- description of the first difference

    def _difference(self) -> Difference | None:
        damaged, found = _first_damaged(self.frames), self._found()
        if damaged is not None and (found is None or damaged < found.place):
            return Difference("wrong CRC, in a frame that the replay does not compare", damaged, self.frames[damaged])
        return found or self._damaged_at_the_end()

    def _damaged_at_the_end(self) -> Difference | None:
        """Returns the first damaged frame after the last tick in the log, as a difference."""
        for place in range(self._state.former_tick_place, len(self.frames)):
            if _is_damaged(self.frames[place]):
                return Difference("wrong CRC, in a frame after the last tick in the log", place, self.frames[place])
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
                else "the trace ends before this frame, so that the rest cannot be replayed"
            )
            return Difference(what, state.place, recorded)
        if state.result == lib.REPLAY_NOT_IN_LOG:
            sent = self._sent(recorded)
            return Difference(
                f"in this tick the firmware sends a {sent.name} that is not in the log", state.place, recorded, sent
            )
        if state.result == lib.REPLAY_DAMAGED:
            return Difference("wrong CRC, in a frame that the firmware sent or accepted", state.place, recorded)
        lost = messages()[state.sent.id].name
        return Difference(
            f"in this tick the firmware read a {lost} with counter {state.sent.data[0]}, which is not in the log, or "
            "more frames than a tick can read",
            state.place,
            recorded,
        )

    def _sent(self, recorded: Frame) -> Frame:
        sent = self._state.sent
        data = bytes(self._ffi.buffer(sent.data, sent.length))
        return recorded._replace(frame_id=sent.id, data=data, extended=False, remote=False, error=False)
