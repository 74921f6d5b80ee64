"""Generates inputs for controller_step(): recorded runs, tick by tick as the firmware read them, and random vectors."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from comanip._core import ffi, lib
from comanip.bus import logs
from comanip.bus.frame import Frame
from comanip.replay import Replay

TICK, BOOT_FD, BOOT_CLASSIC = 0, 1, 2  # as in records.h
HEAD, FRAME = struct.Struct("<IBB"), struct.Struct("<IHBB")
VECTOR_TICKS_PER_BOOT = 500
SPECIAL_BITS = (  # bit patterns of float32: zeros, denormals, ones, largest number, infinities, NaNs, 1e10, 1e-8
    0x00000000, 0x80000000, 0x00000001, 0x807FFFFF, 0x00800000, 0x3F800000, 0xBF800000, 0x7F7FFFFF,
    0x7F800000, 0xFF800000, 0x7FC00000, 0xFFC12345, 0x7F800001, 0x501502F9, 0x322BCC77,
)  # fmt: skip


def boot(profile: int) -> bytes:
    return HEAD.pack(0, BOOT_FD if profile == lib.CAN_PROFILE_FD else BOOT_CLASSIC, 0)


def tick(now_us: int, frames: Sequence) -> bytes:
    parts = [HEAD.pack(now_us % 2**32, TICK, len(frames))]
    for frame in frames:
        parts.append(FRAME.pack(frame.timestamp_us, frame.id, frame.length, frame.fd))
        parts.append(bytes(frame.data[0 : frame.length]))
    return b"".join(parts)


def now_us(trace: Frame) -> int:
    begin = 2 if trace.name == "ClassicTickTrace" else 3
    return int.from_bytes(trace.data[begin : begin + 4], "little")


def recorded(log: Path) -> Iterator[bytes]:
    """Yields the ticks of a recorded run, starting at boot. Each tick has the frames that the firmware read in that
    tick, as determined by the replay."""
    frames = list(logs.read(log))
    replaying = Replay(frames)
    state = replaying._state
    yield boot(state.profile)
    while state.tick_place != lib.REPLAY_NO_FRAME:
        place = state.tick_place
        replaying.run_to(place + 1)
        if state.result != lib.REPLAY_EQUAL:
            raise AssertionError(f"{log}: replay failed: {replaying.report().difference}")
        yield tick(now_us(frames[place]), [state.inbox.frame[i] for i in range(state.inbox.count)])


class Vectors:
    """Generates frames with random contents: hand poses, joint states, and requests with valid and invalid values. Two
    in a thousand frames have a flipped bit.

    follows: whether the joints follow their commands, as they must for the firmware to keep cooperating. A controller
    beside the generator computes the commands. Otherwise the joints are anywhere, within and beyond their ranges.
    """

    def __init__(self, rng: np.random.Generator, profile: int, follows: bool):
        self._rng, self._profile, self._follows = rng, profile, follows
        self._controller, self._outbox = ffi.new("controller_t *"), ffi.new("outbox_t *")
        lib.controller_init(self._controller, ffi.addressof(lib.arm_ik_hoap3_right), profile)
        self._position_rad = np.array([rng.uniform(*self._range_rad(joint)) for joint in range(4)])
        self._sender = ffi.new("transport_sender_t *")
        lib.transport_sender_init(self._sender, profile, lib.ARM_MAX_JOINTS)
        self._hand = np.array([0.4, 0.2, 0.1])

    def _sent(self, message, now: int) -> list:
        frames = ffi.new("can_frame_t[]", lib.TRANSPORT_MAX_FRAMES)
        count = lib.outbox_frames(self._sender, message, frames)
        result = [ffi.new("can_frame_t *", frames[i]) for i in range(count)]
        for frame in result:
            frame.timestamp_us = (now - int(self._rng.integers(3000))) % 2**32
        return result

    def _number(self) -> float:
        bits = int(self._rng.choice(SPECIAL_BITS)) if self._rng.random() < 0.5 else int(self._rng.integers(2**32))
        return struct.unpack("<f", struct.pack("<I", bits))[0]

    def _pose(self, now: int):
        q = self._rng.normal(size=4) if self._rng.random() < 0.5 else np.array([1, 1e-3, -1e-3, 0])
        q = q / np.linalg.norm(q) * self._rng.choice([1, -1, 1.0005, 0.5])
        self._hand = self._hand + self._rng.normal(size=3) * self._rng.choice([1e-4, 1e-2, 1])
        self._hand = np.clip(self._hand, -3, 3)
        pose = ffi.new(
            "hand_pose_t *",
            {"t_us": (now + int(self._rng.integers(-2000, 1))) % 2**32, "valid": self._rng.random() < 0.95},
        )
        pose.position_m, pose.rotation = dict(zip("xyz", self._hand)), dict(zip("wxyz", q))
        frame = ffi.new("can_frame_t *")
        lib.hand_pose_pack(pose, frame)
        return frame

    @staticmethod
    def _range_rad(joint: int) -> tuple[float, float]:
        row = lib.arm_hoap3_right.joints[joint]
        return row.position_min_rad, row.position_max_rad

    def _state(self, joint: int):
        if self._follows:
            position, error = self._position_rad[joint], self._rng.random() < 1e-4
            mode = lib.DRIVE_MODE_VELOCITY if self._controller.moving else lib.DRIVE_MODE_BRAKE
        else:
            span = self._range_rad(joint)
            position = self._rng.choice([*span, self._rng.uniform(*span), self._rng.uniform(-8, 8), 0.0])
            mode, error = int(self._rng.integers(2)), self._rng.random() < 1e-3
        state = ffi.new("joint_state_t *", {"position_rad": position, "error": int(error), "mode": mode})
        frame = ffi.new("can_frame_t *")
        lib.joint_state_pack(joint, state, frame)
        return frame

    def _request(self):
        frame, kind = ffi.new("can_frame_t *"), self._rng.integers(4)
        if kind == 0:
            message = {"operation": 1, "parameter": int(self._rng.integers(lib.PARAMETER_COUNT + 2)), "sequence": 1}
            access = ffi.new("parameter_access_t *", message)
            access.value = self._number() if self._rng.random() < 0.7 else float(self._rng.uniform(0, 2))
            lib.parameter_access_pack(access, frame)
        elif kind == 1:
            q = [random / np.linalg.norm(random) for random in self._rng.normal(size=(2, 4))]
            define = ffi.new(
                "task_define_t *",
                {"form": int(self._rng.integers(3)), "blend_s": float(self._rng.choice([0, 0.1, 60]))},
            )
            define.t_task_m, define.q_task, define.q_inv = (
                dict(zip("xyz", self._rng.uniform(-1, 1, 3))), dict(zip("wxyz", q[0])),
                dict(zip("wxyz", q[1])))  # fmt: skip
            lib.task_define_pack(define, frame)
        else:
            numbers = [lib.COMMAND_START, lib.COMMAND_ACKNOWLEDGE, int(self._rng.integers(9))]
            number = numbers[int(self._rng.integers(3))]  # often one that leads back to cooperation
            command = ffi.new("operator_command_t *", {"command": number, "task": int(self._rng.integers(5))})
            lib.operator_command_pack(command, frame)
        return frame

    def _move(self, now: int, frames: list) -> None:
        """Advances the joints by the tick in which the firmware reads these frames."""
        inbox = ffi.new("controller_inbox_t *", {"count": len(frames)})
        for i, frame in enumerate(frames):
            inbox.frame[i] = frame
        lib.outbox_step(self._outbox, self._controller, now, inbox)
        velocity_radps = np.array(list(self._controller.limits.velocity_radps)[:4])
        self._position_rad = self._position_rad + velocity_radps * 1e-3 * self._controller.tick_ms

    def ticks(self, count: int) -> Iterator[bytes]:
        period_us = 1000 if self._profile == lib.CAN_PROFILE_FD else 4000
        now = int(self._rng.integers(2**32))
        yield boot(self._profile)
        for i in range(count):
            now = (now + period_us) % 2**32
            frames = (
                []
                if self._rng.random() < 0.01
                else [f for joint in range(4) for f in self._sent(self._state(joint), now)]
            )
            if i % (4 if period_us == 1000 else 2) == 0 and self._rng.random() < 0.98:
                frames += self._sent(self._pose(now), now)
            if self._rng.random() < 0.2:
                frames += self._sent(self._request(), now)
            for frame in frames:
                if self._rng.random() < 2e-3:
                    frame.data[int(self._rng.integers(frame.length))] ^= 1 << int(self._rng.integers(8))
            read = [frame[0] for frame in frames[:16]]
            if self._follows:
                self._move(now, read)
            yield tick(now, read)


def vectors(ticks: int, seed: int) -> Iterator[bytes]:
    rng = np.random.default_rng(seed)
    for part in range(ticks // VECTOR_TICKS_PER_BOOT):
        profile = (lib.CAN_PROFILE_FD, lib.CAN_PROFILE_CLASSIC)[part % 2]
        yield from Vectors(rng, profile, follows=part % 4 < 2).ticks(VECTOR_TICKS_PER_BOOT)
