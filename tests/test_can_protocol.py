"""Checks that cantools, with the DBC, and the firmware decode each other's frames. Also checks values that do not fit
in a frame, and end-to-end protection."""

from __future__ import annotations

import math
import re

import numpy as np
import oracle
import pytest
from bus_log import FD_MESSAGES
from comanip._core import ffi, lib
from e2e import p05

HEADER = ("e2e_crc", "e2e_counter")
XYZ = r"(?P<member>t_task|q_task|q_inv)_(?P<part>[wxyz])(?P<unit>_m)?"
# C members that are named differently from their signals.
RENAMED = {
    "hand_pose_t": {f"{c}_m": f"position_m.{c}" for c in "xyz"} | {f"q{c}": f"rotation.{c}" for c in "wxyz"},
}
MESSAGES = {  # DBC name: C type of the message, base name of its pack and unpack functions
    "HandPose": ("hand_pose_t", "hand_pose"),
    "TrackerStatus": ("tracker_status_t", "tracker_status"),
    "JointCmd": ("joint_cmd_t", "joint_cmd"),
    "OperatorCommand": ("operator_command_t", "operator_command"),
    "TaskDefine": ("task_define_t", "task_define"),
    "ParameterAccess": ("parameter_access_t", "parameter_access"),
    "FirmwareStatus": ("firmware_status_t", "firmware_status"),
    "CommandAck": ("command_ack_t", "command_ack"),
    "ParameterValue": ("parameter_value_t", "parameter_value"),
    "FirmwareIdentity": ("firmware_identity_t", "firmware_identity"),
    "GripperCommand": ("gripper_command_t", "gripper_command"),
    "GripperState": ("gripper_state_t", "gripper_state"),
    "Clearance": ("clearance_t", "clearance"),
} | {f"JointState{i}": ("joint_state_t", "joint_state") for i in range(8)}


class Codec:
    """A message, with its DBC description and the firmware's pack and unpack functions."""

    def __init__(self, dbc, name: str):
        self.dbc_message = dbc.get_message_by_name(name)
        self.c_type, function = MESSAGES[name]
        self.joint = (int(name[-1]),) if function == "joint_state" else ()
        self.c_pack, self.c_unpack = getattr(lib, f"{function}_pack"), getattr(lib, f"{function}_unpack")
        self.signals = [s for s in self.dbc_message.signals if s.name not in HEADER]

    def path(self, signal: str) -> list[str | int]:
        """Returns the C member of a signal: position_3_rad -> position_rad[3]; t_task_x_m -> t_task_m.x"""
        renamed = RENAMED.get(self.c_type, {}).get(signal)
        if renamed:
            return renamed.split(".")
        if match := re.fullmatch(XYZ, signal):
            return [match["member"] + (match["unit"] or ""), match["part"]]
        if match := re.fullmatch(r"(\w+?)_(\d)(_\w+)?", signal):
            return [match[1] + (match[3] or ""), int(match[2])]
        return [signal]

    def set(self, message, signal: str, value) -> None:
        *parents, last = self.path(signal)
        for parent in parents:
            message = getattr(message, parent)
        if isinstance(last, int):
            message[last] = value
        else:
            setattr(message, last, value)

    def get(self, message, signal: str):
        for step in self.path(signal):
            message = message[step] if isinstance(step, int) else getattr(message, step)
        return message

    def pack(self, values: dict) -> tuple[int, object]:
        message, frame = ffi.new(f"{self.c_type} *"), ffi.new("can_frame_t *")
        for signal, value in values.items():
            self.set(message, signal, value)
        return self.c_pack(*self.joint, message, frame), frame

    def decode(self, frame) -> dict:
        return self.dbc_message.decode(bytes(frame.data)[: frame.length], decode_choices=False)

    def raw_range(self, signal) -> tuple[int, int]:
        size = 2**signal.length
        return (-size // 2, size // 2 - 1) if signal.is_signed else (0, size - 1)

    def random_values(self, rng) -> dict:
        values = {}
        for signal in self.signals:
            if signal.is_float:
                values[signal.name] = float(np.float32(rng.normal() * 10.0 ** rng.integers(-6, 6)))
                continue
            low, high = self.raw_range(signal)
            raw = int(rng.integers(low, high, endpoint=True, dtype=np.uint64 if low == 0 else np.int64))
            values[signal.name] = raw * signal.scale if signal.scale != 1 else raw
        return values


def is_close(a: float, b: float, resolution: float) -> bool:
    """Returns whether two numbers agree within the resolution plus the float32 rounding error of the value."""
    return abs(a - b) <= resolution + 1.3e-7 * abs(b)


@pytest.mark.parametrize("name", MESSAGES)
def test_cantools_decodes_packed_frames(dbc, rng, name):
    codec = Codec(dbc, name)
    for _ in range(300):
        values = codec.random_values(rng)
        # include values between two steps of the signal
        shifted = {
            s.name: values[s.name] * (1 - 1e-3 * rng.random()) if s.scale < 1 else values[s.name] for s in codec.signals
        }
        status, frame = codec.pack(shifted)
        assert status == lib.PROTOCOL_OK
        assert (frame.id, frame.length) == (codec.dbc_message.frame_id, codec.dbc_message.length)
        decoded = codec.decode(frame)
        for signal in codec.signals:
            half = 0 if signal.is_float else 0.5 * signal.scale if signal.scale != 1 else 0
            assert is_close(decoded[signal.name], shifted[signal.name], half), signal.name


@pytest.mark.parametrize("name", MESSAGES)
def test_frames_encoded_by_cantools_are_unpacked(dbc, rng, name):
    codec = Codec(dbc, name)
    for _ in range(300):
        values = codec.random_values(rng)
        frame = ffi.new("can_frame_t *", {"id": codec.dbc_message.frame_id, "length": codec.dbc_message.length})
        data = codec.dbc_message.encode(values | dict.fromkeys(HEADER, 0), strict=False)
        ffi.memmove(frame.data, data, len(data))
        message = ffi.new(f"{codec.c_type} *")
        codec.c_unpack(frame, message)
        for signal in codec.signals:
            assert is_close(codec.get(message, signal.name), values[signal.name], 0), signal.name


SCALED = [
    (name, signal)
    for name, signals in {
        "HandPose": ["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"],
        "TaskDefine": ["t_task_x_m", "t_task_z_m", "q_task_w", "q_task_z", "q_inv_w", "q_inv_z", "blend_s"],
        "JointCmd": ["position_0_rad", "velocity_0_radps", "torque_0_Nm", "position_7_rad", "velocity_7_radps"],
        "JointState3": ["position_rad", "velocity_radps", "torque_Nm"],
        "FirmwareStatus": ["speed_limit_percent"],
        "GripperState": ["opening_percent", "force_N"],
        "Clearance": ["person_m", "self_m"],
    }.items()
    for signal in signals
]


@pytest.mark.parametrize(("name", "signal"), SCALED)
def test_a_value_out_of_range_is_refused_not_saturated(dbc, name, signal):
    codec = Codec(dbc, name)
    [description] = [s for s in codec.signals if s.name == signal]
    low, high = (raw * description.scale for raw in codec.raw_range(description))
    margin = 1e-6 * (high - low) + description.scale
    beyond = (low - margin, high + margin, math.nan, math.inf, -math.inf, 1e9, -1e9, 3e38)
    for value in beyond:
        assert codec.pack({signal: value})[0] == lib.PROTOCOL_OUT_OF_RANGE, value
    for value in (low + margin, high - margin):
        status, frame = codec.pack({signal: value})
        assert status == lib.PROTOCOL_OK
        assert is_close(codec.decode(frame)[signal], value, 0.5 * description.scale)


@pytest.mark.parametrize("value", [9.0, -9.0, math.nan, math.inf])
@pytest.mark.parametrize("signal", ["x_m", "z_m", "qw"])
def test_a_pose_out_of_range_is_sent_as_invalid(dbc, signal, value):
    codec = Codec(dbc, "HandPose")
    good = {"t_us": 123456, "x_m": 0.1, "qw": 1.0, "valid": True}
    status, frame = codec.pack(good | {signal: value})
    decoded = codec.decode(frame)
    assert status == lib.PROTOCOL_OUT_OF_RANGE
    assert (decoded["valid"], decoded["t_us"]) == (0, 123456)
    assert codec.decode(codec.pack(good)[1])["valid"] == 1


@pytest.mark.parametrize("period_us", [0, 10, 4000, 4004, 4006, 655_350])
def test_tracker_period_is_rounded_to_its_resolution(dbc, period_us):
    codec = Codec(dbc, "TrackerStatus")
    status, frame = codec.pack({"period_us": period_us})
    assert status == lib.PROTOCOL_OK
    assert abs(codec.decode(frame)["period_us"] - period_us) <= 5
    assert codec.pack({"period_us": 700_000})[0] == lib.PROTOCOL_OUT_OF_RANGE


# ---- TickTrace and FirmwareHeartbeat, whose signals are not copied one to one from members of a C struct

RECEIVED = {
    "hand_pose": lib.FRAME_HAND_POSE,
    "tracker_status": lib.FRAME_TRACKER_STATUS,
    "operator_command": lib.FRAME_OPERATOR_COMMAND,
    "task_define": lib.FRAME_TASK_DEFINE,
    "parameter_access": lib.FRAME_PARAMETER_ACCESS,
} | {f"joint_state_{i}": lib.FRAME_JOINT_STATE0 + i for i in range(8)}


def test_tick_trace_carries_counters_target_and_age(dbc, rng):
    message = dbc.get_message_by_name("TickTrace")
    for target in oracle.random_poses(rng, 200, 2.0):
        trace, frame = ffi.new("tick_trace_t *"), ffi.new("can_frame_t *")
        counters = {name: int(rng.integers(256)) for name in RECEIVED}
        started = {name: bool(rng.integers(2)) for name in RECEIVED}
        last = ffi.new("e2e_receiver_t[]", lib.FRAME_KIND_COUNT)
        for name, kind in RECEIVED.items():
            last[kind] = (started[name], counters[name])
        lib.protocol_trace_inputs(last, trace)
        trace.now_us, trace.hand_age_us, trace.target_valid = int(rng.integers(2**32)), int(rng.integers(2**24)), True
        trace.drives_fresh, trace.rejected_frames = bool(rng.integers(2)), int(rng.integers(256))
        trace.target = (target[:4].tolist(), oracle.translation(target).tolist())
        assert lib.tick_trace_pack(trace, frame) == lib.PROTOCOL_OK
        decoded = message.decode(bytes(frame.data)[: frame.length])
        assert {name: decoded[f"{name}_counter"] for name in RECEIVED} == counters
        assert (decoded["now_us"], decoded["hand_age_us"], decoded["target_valid"]) == (
            trace.now_us,
            trace.hand_age_us,
            1,
        )
        assert (decoded["drives_fresh"], decoded["rejected_frames"]) == (trace.drives_fresh, trace.rejected_frames)
        position = [decoded[f"target_{c}_m"] for c in "xyz"]
        rotation = [decoded[f"target_q{c}"] for c in "wxyz"]
        assert np.abs(oracle.translation(target) - position).max() < 1.5e-6
        assert np.abs(target[:4] - rotation).max() < 0.5 * 2**-14 + 1e-7
        back = ffi.new("tick_trace_t *")
        lib.tick_trace_unpack(frame, back)
        unpacked = np.frombuffer(
            ffi.buffer(ffi.new("dual_quaternion_t *", lib.pose_to_dual_quaternion(back.target))), np.float32
        )
        assert oracle.pose_distance(unpacked, target) < 2e-4
        read = ffi.new("e2e_receiver_t[]", lib.FRAME_KIND_COUNT)
        lib.protocol_traced_inputs(back, read)
        assert {name: read[kind].counter for name, kind in RECEIVED.items()} == counters
        assert {name: read[kind].started for name, kind in RECEIVED.items()} == started
        assert (back.now_us, back.hand_age_us) == (trace.now_us, trace.hand_age_us)
        assert (back.drives_fresh, back.rejected_frames) == (trace.drives_fresh, trace.rejected_frames)


def test_tick_trace_marks_a_target_that_it_cannot_carry(dbc):
    trace, frame = ffi.new("tick_trace_t *"), ffi.new("can_frame_t *")
    trace.hand_age_us, trace.target_valid = 2**24 - 1, True
    trace.target = ([1, 0, 0, 0], [9, 0, 0])
    assert lib.tick_trace_pack(trace, frame) == lib.PROTOCOL_OUT_OF_RANGE
    decoded = dbc.get_message_by_name("TickTrace").decode(bytes(frame.data)[: frame.length])
    assert (decoded["hand_age_us"], decoded["target_valid"], decoded["target_x_m"]) == (2**24 - 1, 0, 0)


def test_an_age_beyond_24_bits_is_out_of_range():
    trace, frame = ffi.new("tick_trace_t *", {"hand_age_us": 2**24}), ffi.new("can_frame_t *")
    assert lib.tick_trace_pack(trace, frame) == lib.PROTOCOL_OUT_OF_RANGE


def test_heartbeat(dbc):
    frame = ffi.new("can_frame_t *")
    for state in (
        lib.HEARTBEAT_BOOT_UP,
        lib.HEARTBEAT_STOPPED,
        lib.HEARTBEAT_OPERATIONAL,
        lib.HEARTBEAT_PRE_OPERATIONAL,
    ):
        assert (
            lib.firmware_heartbeat_pack(ffi.new("firmware_heartbeat_t *", {"state": state}), frame) == lib.PROTOCOL_OK
        )
        message = dbc.get_message_by_frame_id(frame.id)
        assert (message.name, message.length) == ("FirmwareHeartbeat", frame.length)
        assert message.decode(bytes(frame.data)[:1], decode_choices=False) == {"state": state}


# ---- one schema


def kind_of(message) -> int:
    """Returns the frame_kind_t of a DBC message, from its name."""
    name = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", message.name).upper()
    if match := re.fullmatch(r"JOINT_STATE(\d)", name):
        return lib.FRAME_JOINT_STATE0 + int(match[1])
    return getattr(lib, f"FRAME_{name}")


def attribute(message, name: str) -> int:
    found = message.dbc.attributes.get(name)
    return int(found.value) if found else 0


def test_frame_table_matches_the_dbc():
    assert len(FD_MESSAGES) == lib.FRAME_KIND_COUNT
    for message in FD_MESSAGES:
        row = lib.frame_table[kind_of(message)]
        assert (row.id, row.length) == (message.frame_id, message.length), message.name
        assert row.data_id == attribute(message, "E2EDataId")
        assert (row.period_ms, row.timeout_ms) == (message.cycle_time or 0, attribute(message, "TimeoutMs"))


def test_data_ids_differ(dbc):
    data_ids = [row.data_id for row in map(lib.frame_table.__getitem__, range(lib.FRAME_KIND_COUNT)) if row.data_id]
    assert len(set(data_ids)) == len(data_ids) == lib.FRAME_KIND_COUNT - 1


@pytest.mark.parametrize(
    ("prefix", "message", "signal"),
    [
        ("MODE_", "FirmwareStatus", "mode"),
        ("REASON_", "FirmwareStatus", "reason"),
        ("STOP_", "FirmwareStatus", "stop_category"),
        ("TASK_", "FirmwareStatus", "task"),
        ("COMMAND_", "CommandAck", "command"),
        ("RESULT_", "CommandAck", "result"),
        ("DRIVE_MODE_", "JointState0", "mode"),
        ("DRIVE_ERROR_", "JointState0", "error"),
        ("TASK_FORM_", "TaskDefine", "form"),
        ("PARAMETER_", "ParameterAccess", "operation"),
        ("HEARTBEAT_", "FirmwareHeartbeat", "state"),
        ("GRIPPER_", "GripperCommand", "action"),
        ("GRIPPER_STATUS_", "GripperState", "state"),
        ("PERSON_PART_", "Clearance", "person_part"),
        ("ROBOT_PART_", "Clearance", "robot_part"),
    ],
)
def test_enumerations_match_the_dbc(dbc, prefix, message, signal):
    kinds = {
        "MODE_": "control_mode_t", "REASON_": "reason_t", "STOP_": "stop_category_t", "TASK_": "task_id_t",
        "COMMAND_": "command_t", "RESULT_": "result_t", "DRIVE_MODE_": "drive_mode_t", "DRIVE_ERROR_": "drive_error_t",
        "TASK_FORM_": "task_form_t", "PARAMETER_": "parameter_operation_t", "HEARTBEAT_": "heartbeat_state_t",
        "GRIPPER_": "gripper_action_t", "GRIPPER_STATUS_": "gripper_status_t",
        "PERSON_PART_": "person_part_t", "ROBOT_PART_": "robot_part_t",
    }  # fmt: skip
    ours = {number: name.removeprefix(prefix).lower() for number, name in ffi.typeof(kinds[prefix]).elements.items()}
    choices = dbc.get_message_by_name(message).get_signal_by_name(signal).choices
    theirs = {number: str(choice) for number, choice in choices.items()}
    assert ours == theirs


def test_clearance_names_the_two_halves_of_the_robot_alike(dbc):
    """arm_part and body_part use the same numbers as robot_part, so that a single enumeration serves all three
    signals."""
    signal = dbc.get_message_by_name("Clearance").get_signal_by_name
    robot, arm, body = (
        [str(name) for _, name in sorted(signal(f"{part}_part").choices.items())] for part in ("robot", "arm", "body")
    )
    assert robot == arm + body
    assert len(arm) == lib.ROBOT_PART_UPPER_ARM


# ---- protection


def frame_of(message, data: bytes | None = None):
    frame = ffi.new("can_frame_t *", {"id": message.frame_id, "length": message.length})
    ffi.memmove(frame.data, bytes(message.length) if data is None else data, message.length)
    return frame


def checked(receiver, frame) -> int:
    kind = ffi.new("frame_kind_t *")
    return (
        lib.protocol_check(receiver, frame, kind[0]) if lib.protocol_find(frame.id, kind) else lib.PROTOCOL_UNKNOWN_ID
    )


def test_every_protected_frame_verifies_with_autosar_e2e(rng):
    sender = ffi.new("protocol_sender_t *")
    for counter in range(300):
        for message in FD_MESSAGES:
            data_id = attribute(message, "E2EDataId")
            frame = frame_of(message, rng.bytes(message.length))
            before = bytes(frame.data)
            lib.protocol_protect(sender, frame)
            data = bytes(frame.data)[: message.length]
            if data_id:
                assert p05.e2e_p05_check(data, data_id)
                assert data[2] == counter % 256  # each id has its own counter
            else:
                assert bytes(frame.data) == before


def test_check_accepts_a_senders_frames_and_names_their_kind():
    sender, receiver, kind = ffi.new("protocol_sender_t *"), ffi.new("protocol_receiver_t *"), ffi.new("frame_kind_t *")
    for _ in range(300):
        for message in FD_MESSAGES:
            frame = frame_of(message)
            lib.protocol_protect(sender, frame)
            assert lib.protocol_find(frame.id, kind)
            assert kind[0] == kind_of(message)
            assert lib.protocol_check(receiver, frame, kind[0]) == lib.PROTOCOL_OK
    assert receiver.rejected == 0


def test_check_refuses_and_counts(dbc):
    message = dbc.get_message_by_name("HandPose")
    sender, receiver = ffi.new("protocol_sender_t *"), ffi.new("protocol_receiver_t *")
    frame = frame_of(message)
    lib.protocol_protect(sender, frame)
    assert checked(receiver, frame) == lib.PROTOCOL_OK
    assert checked(receiver, frame) == lib.PROTOCOL_NOT_AUTHENTIC  # repeated
    lib.protocol_protect(sender, frame)
    frame.data[20] ^= 1
    assert checked(receiver, frame) == lib.PROTOCOL_NOT_AUTHENTIC  # corrupted
    frame.length = 24
    assert checked(receiver, frame) == lib.PROTOCOL_WRONG_LENGTH
    frame.id, frame.length = dbc.get_message_by_name("JointCmd").frame_id, 64
    assert checked(receiver, frame) == lib.PROTOCOL_NOT_AUTHENTIC  # protected as a frame with another id
    assert receiver.rejected == 4


def test_an_unknown_id_is_not_an_error():
    receiver = ffi.new("protocol_receiver_t *")
    assert checked(receiver, ffi.new("can_frame_t *", {"id": 0x7FF, "length": 8})) == lib.PROTOCOL_UNKNOWN_ID
    assert receiver.rejected == 0
