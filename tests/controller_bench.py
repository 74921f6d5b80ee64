"""Runs controller_step() on a test bench with a tracker, an operator, and ideal drives, which follow each command
without delay. They communicate with the controller only through frames."""

from __future__ import annotations

import numpy as np
import oracle
from comanip._core import ffi, lib

TICK_US = 1000
TRACKER_PERIOD_TICKS = 4
JOINTS = 4
KINDS = {number: name.removeprefix("FRAME_") for number, name in ffi.typeof("frame_kind_t").elements.items()}
FRAME_ID = {KINDS[number]: lib.frame_table[number].id for number in range(lib.FRAME_KIND_COUNT)}
TRACKER = oracle.pose(oracle.rotation([1, 0, 0], -np.pi / 2), [0, 0, 0])  # equation (9) of the paper


class Bench:
    """A controller with simulated drives, tracker and operator.

    position_rad: the arm's true joint angles, which `drive` advances by a tick. encoder: what the drives report of
    them. mode_reported: the mode that all drives report, or None for the one last commanded.
    hand: pose (8,) of the person's hand in torso axes, or None to send no tracker frames.
    prediction: whether the hand's motion is predicted; None selects Bench.prediction. Prediction is off by default,
    because after a jump of the hand, which many tests make, the predicted motion takes time to settle.
    store_result: the result that the port reports `store_ticks` ticks after a save has started. stored: the values
    written by each save.
    """

    prediction = False

    def __init__(
        self,
        position_deg=(90, -5, 0, -90),
        now_us: int = 0,
        parameters=None,
        boot_result: int = 0,
        prediction: bool | None = None,
    ):
        self.position_rad = np.radians(np.array(position_deg, float))
        self.hand = oracle.pose(oracle.rotation([0, 1, 0], np.pi / 2), [0.4, 0.2, 0.1])
        self.hand_valid = True
        self.drives_answer = True
        self.drive = lambda position_rad, velocity_radps: position_rad + velocity_radps * TICK_US * 1e-6
        self.encoder = lambda position_rad: position_rad
        self.mode_reported: int | None = None
        self.command_sent = ffi.new("joint_cmd_t *")  # the last command
        self.drive_error = lib.DRIVE_ERROR_NONE
        self.now_us = now_us
        self.stamp_offset_us = 0  # added to the reception time of each frame
        self.tracker_clock_offset_us = 0
        self.ticks = 0
        self.sequence = 0
        self.requests: list = []
        self.raw: list = []  # frames to send to the controller unchanged in the next tick
        self.sent: list[tuple[int, bytes]] = []  # (id, data) of each frame from the controller
        self.controller = ffi.new("controller_t *")
        self.sender = ffi.new("protocol_sender_t *")
        self.inbox = ffi.new("controller_inbox_t *")
        self.outbox = ffi.new("outbox_t *")
        self.store_result, self.store_ticks = lib.RESULT_NOT_SUPPORTED, 1
        self.stored: list[list[float]] = []
        self.store_until = 0  # tick at which the save ends
        lib.controller_init(self.controller, ffi.addressof(lib.arm_ik_hoap3_right), lib.CAN_PROFILE_FD)
        if parameters is None:
            parameters = ffi.new("parameters_t *")
            lib.parameters_set_defaults(parameters)
            parameters.value[lib.PARAMETER_PREDICTION] = self.prediction if prediction is None else prediction
        lib.controller_set_parameters(self.controller, parameters, boot_result)

    # ---- frames to the controller

    def _receive(self, frame) -> None:
        lib.protocol_protect(self.sender, frame)
        frame.timestamp_us = (self.now_us + self.stamp_offset_us) % 2**32
        self.inbox.frame[self.inbox.count] = frame[0]
        self.inbox.count += 1

    def _tracker_frame(self):
        """Returns a HandPose frame with the hand's pose in the tracker's axes, computed with equation (9)."""
        seen = oracle.multiply(TRACKER, self.hand)
        message = ffi.new(
            "hand_pose_t *", {"t_us": (self.now_us + self.tracker_clock_offset_us) % 2**32, "valid": self.hand_valid}
        )
        t, r = oracle.translation(seen), seen[:4]
        message.position_m = {"x": t[0], "y": t[1], "z": t[2]}
        message.rotation = {"w": r[0], "x": r[1], "y": r[2], "z": r[3]}
        frame = ffi.new("can_frame_t *")
        assert lib.hand_pose_pack(message, frame) == lib.PROTOCOL_OK
        return frame

    def _drive_frame(self, joint: int):
        mode = self.command_sent.mode[joint] if self.mode_reported is None else self.mode_reported
        message = ffi.new("joint_state_t *", {"error": self.drive_error, "mode": mode})
        message.position_rad = self.encoder(self.position_rad)[joint]
        frame = ffi.new("can_frame_t *")
        assert lib.joint_state_pack(joint, message, frame) == lib.PROTOCOL_OK
        return frame

    # ---- operator requests, each answered in the next tick

    def _ask(self, pack, message) -> int:
        frame = ffi.new("can_frame_t *")
        assert pack(message, frame) == lib.PROTOCOL_OK
        self.requests.append(frame)
        self.tick()
        return self.answer()

    def _next_sequence(self) -> int:
        self.sequence = (self.sequence + 1) % 256
        return self.sequence

    def command(self, command: int, task: int = 0) -> int:
        """Sends a command and returns the result_t in its acknowledgement."""
        message = ffi.new("operator_command_t *", {"command": command, "sequence": self._next_sequence(), "task": task})
        return self._ask(lib.operator_command_pack, message)

    def define(self, t_task=(0, 0, 0), q_task=(1, 0, 0, 0), q_inv=(1, 0, 0, 0), form=0, blend_s=0.0) -> int:
        message = ffi.new("task_define_t *", {"sequence": self._next_sequence(), "form": form, "blend_s": blend_s})
        message.t_task_m = dict(zip("xyz", t_task))
        message.q_task = dict(zip("wxyz", q_task))
        message.q_inv = dict(zip("wxyz", q_inv))
        return self._ask(lib.task_define_pack, message)

    def write(self, parameter: int, value: float) -> int:
        return self.access(lib.PARAMETER_WRITE, parameter, value)

    def access(self, operation: int, parameter: int, value: float) -> int:
        message = ffi.new("parameter_access_t *", {"operation": operation, "parameter": parameter})
        message.sequence, message.value = self._next_sequence(), value
        return self._ask(lib.parameter_access_pack, message)

    def save(self, parameter: int = 0, ticks: int = 10) -> int:
        """Sends a save command and returns its result, which arrives once the values have been stored."""
        message = ffi.new("parameter_access_t *", {"operation": lib.PARAMETER_SAVE, "parameter": parameter})
        message.sequence = self._next_sequence()
        self.ask(message)
        for _ in range(ticks):
            self.tick()
            if self.answers():
                break
        return self.answer()

    def ask(self, message) -> None:
        """Sends a parameter_access_t in the next tick."""
        frame = ffi.new("can_frame_t *")
        assert lib.parameter_access_pack(message, frame) == lib.PROTOCOL_OK
        self.requests.append(frame)

    def receive_broken(self) -> None:
        """Sends an OperatorCommand with a flipped bit in the next tick."""
        frame = ffi.new("can_frame_t *")
        assert lib.operator_command_pack(ffi.new("operator_command_t *"), frame) == lib.PROTOCOL_OK
        self._receive_broken(frame)

    def receive_broken_between_others(self) -> None:
        """Sends a Clearance with a flipped bit in the next tick. The firmware does not use Clearance, but a port
        without receive filters passes such frames to the controller."""
        frame = ffi.new("can_frame_t *")
        assert lib.clearance_pack(ffi.new("clearance_t *"), frame) == lib.PROTOCOL_OK
        self._receive_broken(frame)

    def _receive_broken(self, frame) -> None:
        lib.protocol_protect(self.sender, frame)
        frame.data[7] ^= 1
        self.raw.append(frame)

    # ---- one tick

    def tick(self, count: int = 1) -> None:
        for _ in range(count):
            self.now_us += TICK_US
            self.inbox.count = 0
            if self.hand is not None and self.ticks % TRACKER_PERIOD_TICKS == 0:
                self._receive(self._tracker_frame())
            if self.drives_answer:
                for joint in range(JOINTS):
                    self._receive(self._drive_frame(joint))
            for frame in self.requests:
                self._receive(frame)
            self.requests.clear()
            for frame in self.raw:
                frame.timestamp_us = self.now_us % 2**32
                self.inbox.frame[self.inbox.count] = frame[0]
                self.inbox.count += 1
            self.raw.clear()
            self.inbox.save_over, self.inbox.save_result = self.ticks >= self.store_until, self.store_result
            lib.outbox_step(self.outbox, self.controller, self.now_us % 2**32, self.inbox)
            if self.outbox.save:
                self.stored.append(list(self.controller.parameters.value))
                self.store_until = self.ticks + self.store_ticks
            frames = [self.outbox.frame[i] for i in range(self.outbox.count)]
            self.sent = [(f.id, bytes(f.data[0 : f.length])) for f in frames]
            for frame in frames:
                if frame.id == FRAME_ID["JOINT_CMD"]:
                    lib.joint_cmd_unpack(ffi.addressof(frame), self.command_sent)
            self.position_rad = self.drive(self.position_rad, self.velocity_radps)
            self.ticks += 1

    # ---- frames from the controller

    def answer(self) -> int:
        """Returns the result in the one CommandAck or ParameterValue that carries the last request's sequence
        number."""
        results = self.answers()
        assert len(results) == 1, f"expected one answer, got {results}"
        return results[0]

    def answers(self) -> list[int]:
        """Returns the results in all answers of this tick that carry the last request's sequence number."""
        results = []
        for i in range(self.outbox.count):
            frame = ffi.addressof(self.outbox.frame[i])
            if frame.id == FRAME_ID["COMMAND_ACK"]:
                message = ffi.new("command_ack_t *")
                lib.command_ack_unpack(frame, message)
            elif frame.id == FRAME_ID["PARAMETER_VALUE"]:
                message = ffi.new("parameter_value_t *")
                lib.parameter_value_unpack(frame, message)
            else:
                continue
            if message.sequence == self.sequence:
                results.append(message.result)
        return results

    @property
    def mode(self) -> int:
        return self.controller.supervisor.mode

    @property
    def reason(self) -> int:
        return self.controller.supervisor.reason

    @property
    def velocity_radps(self) -> np.ndarray:
        return np.array([self.command_sent.velocity_radps[i] for i in range(JOINTS)])

    @property
    def drive_modes(self) -> list[int]:
        return [self.command_sent.mode[i] for i in range(JOINTS)]

    @property
    def trace(self):
        """Returns this tick's tick_trace_t, or None if none was sent."""
        for i in range(self.outbox.count):
            frame = ffi.addressof(self.outbox.frame[i])
            if frame.id == FRAME_ID["TICK_TRACE"]:
                message = ffi.new("tick_trace_t *")
                lib.tick_trace_unpack(frame, message)
                return message
        return None

    @property
    def target(self) -> np.ndarray | None:
        """Returns the target (8,) in this tick's TickTrace, or None if no TickTrace was sent or if the TickTrace marks
        the target as invalid."""
        trace = self.trace
        if trace is None or not trace.target_valid:
            return None
        vec8 = ffi.new("dual_quaternion_t *", lib.pose_to_dual_quaternion(trace.target))
        return np.frombuffer(bytes(ffi.buffer(vec8)), np.float32)

    @property
    def robot(self) -> np.ndarray:
        return oracle.hoap3().fkm(self.position_rad).vec8()

    # ---- common set-up steps

    def until_ready(self) -> Bench:
        self.tick(60)  # long enough to include the boot announcement
        assert self.mode == lib.MODE_READY
        return self

    def start(self, task: int, blend_s: float = 0.0) -> Bench:
        assert self.write(lib.PARAMETER_TASK_BLEND_S, blend_s) == lib.RESULT_ACCEPTED
        assert self.command(lib.COMMAND_SELECT, task) == lib.RESULT_ACCEPTED
        assert self.command(lib.COMMAND_START) == lib.RESULT_ACCEPTED
        return self

    def move_hand(self, displacement_m) -> None:
        self.hand = oracle.pose(self.hand[:4], oracle.translation(self.hand) + np.asarray(displacement_m, float))
