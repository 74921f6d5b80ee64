"""Checks messages on classic CAN, which the C core splits and reassembles, against cantools (contents of the frames),
the package autosar-e2e (Profile 2) and numpy (rotations). No expected value comes from the sender under test."""

from __future__ import annotations

import math

import numpy as np
import pytest
from bus_log import CLASSIC_MESSAGES, DBC, FD_MESSAGES
from comanip._core import ffi, lib
from e2e import p02

ALL_KINDS = (1 << lib.FRAME_KIND_COUNT) - 1
JOINTS = 4
POSE_PERIOD_US = 8000
POSITION_STEP_M, TORQUE_STEP_NM = 1e-4, 0.2
# The three smaller components have 15 bits each and are off by up to half a step. The largest component is computed
# from the other three and is off by up to three half steps (when all four are 1/2). A quaternion error dq causes an
# angle error of 2 |dq|.
ROTATION_ERROR_DEG = math.degrees(2 * math.sqrt(3 + 9) * 0.5 * math.sqrt(0.5) / 16383) * 1.001
STAMP_STEP_US, STAMP_PERIOD_US = 1024, 262_144


def data_id_list(name: str) -> bytes:
    """Returns the DataIDList of Profile 2, as defined in docs/bus.md."""
    base = DBC.get_message_by_name(name).dbc.attributes["E2EDataId"].value
    return bytes((base + 16 * n) % 256 for n in range(16))


class Sender:
    def __init__(self, joints: int = JOINTS, profile: int = lib.CAN_PROFILE_CLASSIC):
        self.state = ffi.new("transport_sender_t *")
        lib.transport_sender_init(self.state, profile, joints)

    def send(self, message, at_us: int = 0) -> list:
        frames = ffi.new("can_frame_t[]", lib.TRANSPORT_MAX_FRAMES)
        count = lib.outbox_frames(self.state, message, frames)
        sent = [ffi.new("can_frame_t *", frames[i]) for i in range(count)]
        for frame in sent:
            frame.timestamp_us = at_us % 2**32
        return sent


class Receiver:
    def __init__(self, kinds: int = ALL_KINDS, joints: int = JOINTS, profile: int = lib.CAN_PROFILE_CLASSIC):
        self.state, self.kind = ffi.new("transport_receiver_t *"), ffi.new("frame_kind_t *")
        lib.transport_receiver_init(self.state, profile, joints, kinds)

    def take(self, frame) -> tuple[int, object]:
        """Feeds a copy of the frame to the receiver. Returns the status and the frame as the receiver left it."""
        copy = ffi.new("can_frame_t *", frame[0])
        return lib.transport_receive(self.state, copy, self.kind), copy

    def message(self, frames: list):
        """Feeds the frames and returns the message. Checks that the message completes with the last frame and not
        earlier."""
        *before, last = [self.take(frame) for frame in frames]
        assert [status for status, _ in before] == [lib.PROTOCOL_INCOMPLETE] * len(before)
        assert last[0] == lib.PROTOCOL_OK
        return last[1]

    @property
    def rejected(self) -> int:
        return self.state.protocol.rejected


def named(frame) -> str:
    return DBC.get_message_by_frame_id(frame.id).name


def payload(frame) -> bytes:
    return bytes(frame.data[0 : frame.length])


def decoded(frame) -> dict:
    return DBC.decode_message(frame.id, payload(frame), decode_choices=False)


def quaternion_of(signals: dict, prefix: str) -> np.ndarray:
    """Decodes a smallest-three quaternion. The largest component is non-negative and is chosen so that the norm is
    1."""
    smaller = [signals[f"{prefix}_{letter}"] for letter in "abc"]
    largest = math.sqrt(max(0.0, 1.0 - sum(c * c for c in smaller)))
    return np.insert(np.array(smaller), int(signals[f"{prefix}_largest"]), largest)


def angle_deg(a: np.ndarray, b: np.ndarray) -> float:
    """Returns the angle between two rotations, computed from the sine, which stays precise at small angles."""
    cross = a[0] * b[1:] - b[0] * a[1:] - np.cross(a[1:], b[1:])
    return math.degrees(2 * math.atan2(np.linalg.norm(cross), abs(a @ b)))


def random_rotation(rng) -> np.ndarray:
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


def pose_message(position_m=(0, 0, 0), rotation=(1, 0, 0, 0), t_us: int = 0, valid: bool = True):
    pose = ffi.new("hand_pose_t *", {"t_us": t_us % 2**32, "valid": valid})
    pose.position_m = dict(zip("xyz", map(float, position_m)))
    pose.rotation = dict(zip("wxyz", map(float, rotation)))
    frame = ffi.new("can_frame_t *")
    lib.hand_pose_pack(pose, frame)
    return frame


def pose_of(frame):
    pose = ffi.new("hand_pose_t *")
    lib.hand_pose_unpack(frame, pose)
    p, q = pose.position_m, pose.rotation
    return pose.valid, np.array([p.x, p.y, p.z]), np.array([q.w, q.x, q.y, q.z]), pose.t_us


# ---- the frames


def test_the_table_matches_the_dbc():
    assert len(CLASSIC_MESSAGES) == lib.CLASSIC_FRAME_COUNT
    for place, message in enumerate(CLASSIC_MESSAGES):
        row, attributes = lib.classic_table[place], message.dbc.attributes
        assert (row.id, row.length, row.data_id) == (message.frame_id, message.length, attributes["E2EDataId"].value)
        timeout = attributes.get("TimeoutMs")
        assert (row.period_ms, row.timeout_ms) == (message.cycle_time or 0, timeout.value if timeout else 0)
        assert row.to_firmware == ("Firmware" in message.receivers)
        assert not message.is_fd


def test_no_two_frames_share_a_data_id_at_any_counter():
    lists = [data_id_list(message.name) for message in CLASSIC_MESSAGES]
    for counter in range(16):
        assert len({ids[counter] for ids in lists}) == len(lists)
    assert all(len(set(ids)) == 16 for ids in lists)


QUATERNIONS = {  # for each quaternion of a message: its signals on CAN FD, and its name on classic CAN
    "HandPose": [("qw qx qy qz", "q")],
    "TickTrace": [("target_qw target_qx target_qy target_qz", "target")],
    "TaskDefine": [("q_task_w q_task_x q_task_y q_task_z", "q_task"), ("q_inv_w q_inv_x q_inv_y q_inv_z", "q_inv")],
}


def random_value(signal, rng):
    """Returns a random value that both profiles can carry."""
    if signal.is_float:
        return float(np.float32(rng.normal()))
    if signal.name.endswith("_Nm"):
        return float(rng.integers(-2500, 2500)) / 100
    if signal.choices:
        return int(rng.choice(sorted(signal.choices)))
    if signal.name.endswith("_counter"):
        return int(rng.integers(16))
    if signal.unit == "m" and signal.is_signed:
        return float(rng.integers(-3_200_000, 3_200_000)) / 1e6
    low, high = (
        (-(1 << signal.length - 1), (1 << signal.length - 1) - 1) if signal.is_signed else (0, (1 << signal.length) - 1)
    )
    raw = int(rng.integers(low, high, endpoint=True, dtype=np.int64 if low else np.uint64))
    return raw if signal.scale == 1 else raw * signal.scale


def random_messages(rng):
    """Yields one message of each kind, as its DBC message, its signals, and its CAN FD frame without protection."""
    for message in FD_MESSAGES:
        values = {signal.name: random_value(signal, rng) for signal in message.signals}
        values |= {name: 0 for name in values if name.startswith("e2e")}
        for names, _ in QUATERNIONS.get(message.name, ()):
            values |= dict(zip(names.split(), random_rotation(rng)))
        data = message.encode(values, strict=False)
        frame = ffi.new(
            "can_frame_t *", {"id": message.frame_id, "length": message.length, "data": data.ljust(64, b"\0")}
        )
        frame.fd = True
        yield message, values, frame


def signals_of(parts: list) -> dict:
    """Returns the signals of all parts. Signals of JointCmd are renamed as on CAN FD, where the name contains the
    joint's number."""
    found = {}
    for part in parts:
        joint = named(part).removeprefix("ClassicJointCmd")
        for name, value in decoded(part).items():
            stem, _, unit = name.partition("_")
            found[f"{stem}_{joint}{'_' if unit else ''}{unit}" if joint.isdigit() else name] = value
    return found


def resolution(message, signal) -> float:
    if signal.name.endswith("_Nm"):
        return TORQUE_STEP_NM
    return POSITION_STEP_M if signal.unit == "m" and signal.is_signed else signal.scale


IDENTITY = ("FirmwareIdentity", "build_hash")
NOT_CARRIED = {  # signals that classic CAN changes or drops; other tests check what is sent instead
    IDENTITY, ("HandPose", "t_us"), *((f"JointState{j}", "temperature_degC") for j in range(8))
}  # fmt: skip


def test_cantools_decodes_what_is_sent(rng):
    """cantools decodes every signal of every message to within the signal's resolution, whichever frame carries the
    signal."""
    sender = Sender(joints=8)
    for _ in range(100):
        for message, values, frame in random_messages(rng):
            parts = sender.send(frame)
            if message.name == "FirmwareHeartbeat":
                assert [payload(part) for part in parts] == [payload(frame)] and not parts[0].fd
                continue
            assert all(named(part).startswith("Classic") and not part.fd for part in parts)
            found = signals_of(parts)
            coded = " ".join(names for names, _ in QUATERNIONS.get(message.name, ())).split()
            is_away = not values.get("valid", 1) or not values.get("target_valid", 1)
            for signal in message.signals:
                name = signal.name
                if name.startswith("e2e") or name in coded or (message.name, name) in NOT_CARRIED:
                    continue
                if is_away and signal.unit == "m":
                    assert found[name] == 0, "a signal without a value must be 0"
                    continue
                error = abs(float(found[name]) - float(values[name]))
                assert error <= 0.5 * resolution(message, signal) + 1e-6 * abs(values[name]), (message.name, name)
            for names, prefix in QUATERNIONS.get(message.name, ()):
                sent = np.array([values[name] for name in names.split()])
                coarse_deg = 0 if message.name == "HandPose" else 0.006  # CAN FD already rounds to 2^-14 per component
                assert is_away or angle_deg(quaternion_of(found, prefix), sent) < ROTATION_ERROR_DEG + coarse_deg
            if message.name == "FirmwareIdentity":
                assert int(found["build_hash_high"]) << 48 | int(found["build_hash_low"]) == values["build_hash"]


def test_a_sent_message_is_received(rng):
    """A message is received with the values that were sent, to within their resolutions."""
    sender, receiver = Sender(joints=8), Receiver(joints=8)
    for _ in range(100):
        for message, values, frame in random_messages(rng):
            back = receiver.message(sender.send(frame))
            assert (back.id, back.length) == (message.frame_id, message.length)
            found = DBC.decode_message(back.id, payload(back), decode_choices=False)
            coded = " ".join(names for names, _ in QUATERNIONS.get(message.name, ())).split()
            if not values.get("valid", 1) or not values.get("target_valid", 1):
                continue
            for signal in message.signals:
                name = signal.name
                if name.startswith("e2e") or name in coded or (message.name, name) in NOT_CARRIED - {IDENTITY}:
                    continue
                if signal.scale == 1 and not signal.is_float:
                    assert int(found[name]) == int(values[name]), (message.name, name)
                    continue
                error = abs(found[name] - values[name])
                assert error <= 0.5 * resolution(message, signal) + 1e-6 * abs(values[name]), (message.name, name)
            for names, _ in QUATERNIONS.get(message.name, ()):
                sent, got = (np.array([side[name] for name in names.split()]) for side in (values, found))
                # rounded to 2^-14 per component, both when sent and when received
                coarse_deg = 0 if message.name == "HandPose" else 0.012
                assert angle_deg(got / np.linalg.norm(got), sent) < ROTATION_ERROR_DEG + coarse_deg


def test_rotations_of_all_kinds_are_within_their_error(rng):
    """The rotation error stays within its bound for random rotations, the identity, rotations with ties, and rotations
    in which each component is the largest, with either sign."""
    sender, receiver = Sender(), Receiver()
    special = [np.eye(4)[i] * s for i in range(4) for s in (1, -1)]
    special += [np.array([s, t, 0, 0]) / math.sqrt(2) for s in (1, -1) for t in (1, -1)]
    special += [np.full(4, 0.5), np.full(4, -0.5)]
    worst = 0.0
    for q in [*special, *(random_rotation(rng) for _ in range(20_000))]:
        valid, _, found, _ = pose_of(receiver.message(sender.send(pose_message(rotation=q))))
        assert valid and abs(np.linalg.norm(found) - 1) < 1e-5
        worst = max(worst, angle_deg(found, q))
    assert worst < ROTATION_ERROR_DEG


@pytest.mark.parametrize("position_m", [(3.2768, 0, 0), (0, -3.277, 0), (0, 0, 8.38)])
def test_a_pose_beyond_the_frames_range_is_sent_as_invalid(position_m):
    parts = Sender().send(pose_message(position_m))
    assert decoded(parts[1])["valid"] == 0
    assert not pose_of(Receiver().message(parts))[0]


def test_values_that_cannot_be_carried_are_not_sent():
    define = ffi.new("task_define_t *", {"q_task": {"w": 0.9}, "q_inv": {"w": 1.0}})
    state = ffi.new("joint_state_t *", {"torque_Nm": 25.6})
    access = ffi.new("parameter_access_t *", {"operation": 16})
    frames = ffi.new("can_frame_t[3]")
    assert lib.task_define_pack(define, ffi.addressof(frames, 0)) == lib.PROTOCOL_OK
    assert lib.joint_state_pack(0, state, ffi.addressof(frames, 1)) == lib.PROTOCOL_OK
    assert lib.parameter_access_pack(access, ffi.addressof(frames, 2)) == lib.PROTOCOL_OK
    assert [Sender().send(ffi.addressof(frames, i)) for i in range(3)] == [[], [], []]


# ---- end-to-end protection, Profile 2


def test_every_frame_verifies_with_autosar_e2e(rng):
    sender = Sender(joints=8)
    for count in range(40):
        for _, _, frame in random_messages(rng):
            for part in sender.send(frame):
                if named(part) != "FirmwareHeartbeat":
                    data = payload(part)
                    assert p02.e2e_p02_check(data, data_id_list(named(part)), length=len(data)), named(part)
                    assert data[1] & 15 == count % 16, "parts have equal counters; each message has its own counter"


def test_any_flipped_bit_is_refused():
    for place in range(2):
        for bit in range(64):
            sender, receiver = Sender(), Receiver()
            parts = sender.send(pose_message((1, 2, 3)))
            parts[place].data[bit // 8] ^= 1 << bit % 8
            statuses = [receiver.take(part)[0] for part in parts]
            assert statuses[place] == lib.PROTOCOL_NOT_AUTHENTIC and lib.PROTOCOL_OK not in statuses
            assert receiver.rejected == 1


@pytest.mark.parametrize("last", [0, 7, 15])
def test_the_counter(last):
    """Profile 2 refuses a repeated counter, and a counter that advances by more than E2E_PROFILE2_MAX_DELTA. This limit
    is far below the counter's range of 16."""
    for step in range(16):
        sender, receiver = Sender(), Receiver()
        state = ffi.new("joint_state_t *")
        frame = ffi.new("can_frame_t *")
        lib.joint_state_pack(0, state, frame)
        frames = [sender.send(frame)[0] for _ in range(40)]
        assert receiver.take(frames[last])[0] == lib.PROTOCOL_OK
        status = receiver.take(frames[last + step])[0]
        expected = lib.PROTOCOL_OK if 1 <= step <= lib.E2E_PROFILE2_MAX_DELTA else lib.PROTOCOL_NOT_AUTHENTIC
        assert status == expected, step
        assert receiver.take(frames[last + step + 1])[0] == lib.PROTOCOL_OK, "only one frame is refused"
    assert lib.E2E_PROFILE2_MAX_DELTA < 8


def test_event_frames_are_accepted_after_any_loss():
    sender, receiver = Sender(), Receiver()
    frame = ffi.new("can_frame_t *")
    lib.operator_command_pack(ffi.new("operator_command_t *"), frame)
    frames = [sender.send(frame)[0] for _ in range(20)]
    assert [receiver.take(frames[i])[0] for i in (0, 9, 9, 15)] == [
        lib.PROTOCOL_OK, lib.PROTOCOL_OK, lib.PROTOCOL_NOT_AUTHENTIC, lib.PROTOCOL_OK]  # fmt: skip


# ---- parts of different messages are never mixed


def sample(number: int) -> tuple[np.ndarray, np.ndarray]:
    """Returns a pose that encodes the sample's number in both the position and the rotation."""
    angle = 1e-3 * (number % 3000)
    return np.array([1e-3 * (number % 3000) - 1.5, 0, 0]), np.array([math.cos(angle / 2), math.sin(angle / 2), 0, 0])


def number_of(position: np.ndarray, rotation: np.ndarray) -> tuple[int, int]:
    return round(1e3 * (position[0] + 1.5)), round(1e3 * 2 * math.atan2(rotation[1], rotation[0]))


@pytest.mark.parametrize("lost", [0.0, 0.05, 0.3, 0.6, 0.9])
def test_parts_of_different_poses_are_never_mixed(rng, lost):
    """Both parts of each received pose belong to the same sample, even if parts are lost at random, singly and in long
    runs."""
    sender, receiver = Sender(), Receiver()
    used = 0
    for number in range(3000):
        position, rotation = sample(number)
        burst = (number // 100) % 3 == 2  # loses all positions or all rotations, alternating every 7 samples
        for place, part in enumerate(sender.send(pose_message(position, rotation), number * POSE_PERIOD_US)):
            gone = rng.random() < lost or (burst and place == (number // 7) % 2)
            if gone:
                continue
            status, frame = receiver.take(part)
            if status == lib.PROTOCOL_OK:
                valid, p, q, _ = pose_of(frame)
                assert valid and number_of(p, q) == (number, number)
                used += 1
    assert used > 500 * (1 - lost) ** 2


def test_a_part_that_waited_for_sixteen_samples_is_not_completed():
    """After sixteen samples the counter wraps, so two parts have equal counters although they belong to different
    samples."""
    sender, receiver = Sender(), Receiver()
    samples = [sender.send(pose_message(*sample(i)), i * POSE_PERIOD_US) for i in range(17)]
    assert payload(samples[0][0])[1] & 15 == payload(samples[16][0])[1] & 15
    assert receiver.take(samples[0][0])[0] == lib.PROTOCOL_INCOMPLETE
    assert receiver.take(samples[16][1])[0] == lib.PROTOCOL_INCOMPLETE, (
        "the position belongs to sample 0, the rotation to sample 16"
    )


@pytest.mark.parametrize(
    "name", ["HandPose", "JointCmd", "TickTrace", "TaskDefine", "TrackerStatus", "FirmwareIdentity"]
)
def test_long_messages_need_all_their_parts(rng, name):
    """If a part is missing, the message is not received. The next complete message is received, with its parts in
    any order."""
    for message, _, frame in random_messages(rng):
        if message.name != name:
            continue
        for missing in range(len(Sender().send(frame))):
            sender, receiver = Sender(), Receiver()
            parts = sender.send(frame)
            statuses = [receiver.take(part)[0] for i, part in enumerate(parts) if i != missing]
            assert statuses == [lib.PROTOCOL_INCOMPLETE] * (len(parts) - 1)
            whole = sender.send(frame)
            receiver.message([whole[i] for i in rng.permutation(len(whole))])


def test_a_command_has_as_many_parts_as_the_arm_has_joints():
    command = ffi.new("joint_cmd_t *", {"velocity_radps": [0.1 * (i + 1) for i in range(8)]})
    frame = ffi.new("can_frame_t *")
    assert lib.joint_cmd_pack(command, frame) == lib.PROTOCOL_OK
    for joints in range(1, 9):
        parts = Sender(joints).send(frame)
        assert [named(part) for part in parts] == [f"ClassicJointCmd{i}" for i in range(joints)]
        found = ffi.new("joint_cmd_t *")
        lib.joint_cmd_unpack(Receiver(joints=joints).message(parts), found)
        assert np.allclose(
            list(found.velocity_radps), [0.1 * (i + 1) if i < joints else 0 for i in range(8)], atol=1e-3
        )


def test_commands_for_joints_that_the_arm_does_not_have_are_ignored():
    frame, receiver = ffi.new("can_frame_t *"), Receiver(joints=4)
    lib.joint_cmd_pack(ffi.new("joint_cmd_t *"), frame)
    statuses = [receiver.take(part)[0] for part in Sender(joints=8).send(frame)]
    assert statuses == [lib.PROTOCOL_INCOMPLETE] * 3 + [lib.PROTOCOL_OK] + [lib.PROTOCOL_UNKNOWN_ID] * 4


def test_unsubscribed_frames_are_not_counted_as_refused():
    parts = Sender().send(pose_message())
    receiver = Receiver(kinds=1 << lib.FRAME_TRACKER_STATUS)
    parts[0].data[0] ^= 1
    assert [receiver.take(part)[0] for part in parts] == [lib.PROTOCOL_UNKNOWN_ID] * 2
    assert receiver.rejected == 0


def test_the_profiles_ignore_each_other(rng):
    for message, _, frame in random_messages(rng):
        if message.name == "FirmwareHeartbeat":
            continue
        profiles = (lib.CAN_PROFILE_FD, lib.CAN_PROFILE_CLASSIC)
        for profile, other in (profiles, profiles[::-1]):
            receiver = Receiver(profile=other)
            assert {receiver.take(part)[0] for part in Sender(profile=profile).send(frame)} == {lib.PROTOCOL_UNKNOWN_ID}


# ---- the pose's age


def stamps(times_us, delays_us) -> list[tuple[int, int]]:
    """Returns the true stamp and the receiver's stamp, modulo 2^32, of poses measured at these times and received with
    these delays."""
    sender, receiver = Sender(), Receiver()
    pairs = []
    for t_us, delay_us in zip(times_us, delays_us):
        frame = receiver.message(sender.send(pose_message(t_us=t_us), t_us + delay_us))
        pairs.append((t_us, pose_of(frame)[3]))
    return pairs


@pytest.mark.parametrize("start_us", [0, 2**31 - 300_000, 2**32 - 400_000])
def test_the_stamp_is_restored_to_its_step(rng, start_us):
    """The receiver restores all stamps with the same error, to within one step of the stamp, even after gaps of any
    length and when the clock wraps."""
    gaps_us = rng.choice([8000, 8000, 8000, 16_000, 100_000, 1_000_000, 30_000_000], 300)
    times_us = start_us + np.cumsum(gaps_us)
    pairs = stamps(map(int, times_us), map(int, rng.integers(4000, 60_000, 300)))
    errors = [(found - true) % 2**32 for true, found in pairs]
    spread = [(error - errors[0] + 2**31) % 2**32 - 2**31 for error in errors]
    assert max(map(abs, spread)) < STAMP_STEP_US


def test_a_delay_up_to_131_ms_shows_and_a_longer_one_does_not():
    """Up to the limit stated in docs/bus.md, the receiver computes the true delay of a pose. A longer delay appears
    shorter than it was."""
    for delay_us in range(0, 300_000, 5000):
        (_, first), (true, found) = stamps([0, 8000], [4000, 4000 + delay_us])
        shown_us = (8000 + 4000 + delay_us) - (found - first) - 4000  # the delay as the receiver sees it
        if delay_us < STAMP_PERIOD_US // 2 - STAMP_STEP_US:
            assert abs(shown_us - delay_us) <= STAMP_STEP_US
        elif delay_us > STAMP_PERIOD_US // 2 + STAMP_STEP_US:
            assert shown_us < delay_us - STAMP_PERIOD_US // 2
