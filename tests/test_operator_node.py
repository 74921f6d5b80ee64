"""The operator on the bus with a simulated firmware and gripper: what it sends and when (decoded with cantools), how it
waits, and its error messages."""

from __future__ import annotations

import pytest
from comanip import tasks
from sim_binding import load

ffi, lib = load()

TICK_NS = 1_000_000


class Bench:
    """Plays the script of a scenario and answers each of the operator's frames one tick later."""

    def __init__(self, dbc, *steps, duration_s=30.0, parameters=None, own_tasks=(), wishes=None):
        self.dbc = dbc
        self.scenario = ffi.new("scenario_t *", {"name": b"test", "duration_s": duration_s})
        events = ffi.addressof(self.scenario, "events")
        lib.events_init(events)
        for number, value in (parameters or {}).items():
            self.scenario.parameter_written[number], self.scenario.parameter_value[number] = True, value
        for n, task in enumerate(own_tasks):
            self.scenario.own_task[n].define = task
        for n, step in enumerate(steps):
            self.scenario.operate[n] = self._step(dict(step))
        self.scenario.operate_count = len(steps)
        self.wishes = ffi.new("operator_overrides_t *", wishes or {})
        script = ffi.new("operator_step_t[]", 100)
        self.count = lib.operator_script(self.scenario, self.wishes, script)
        self.events = ffi.new("events_t *", events[0])  # a copy for this run, as the simulator's world makes one
        self.bus = ffi.gc(lib.bus_create(lib.CAN_PROFILE_FD), lib.bus_destroy)
        self._handlers = [ffi.callback("bus_handler_t", self._receive)]
        lib.bus_listen(self.bus, self._handlers[0], ffi.NULL)
        self.firmware, self.gripper = (lib.bus_attach(self.bus, ffi.NULL, ffi.NULL) for _ in range(2))
        self.operator = ffi.gc(
            lib.operator_node_create(self.bus, self.events, script, self.count), lib.operator_node_destroy
        )
        self.senders = ffi.new("protocol_sender_t[2]")
        self.now_ns, self.sent, self._answers = 0, [], []
        self.mode, self.reason, self.task, self.latched = lib.MODE_READY, lib.REASON_INPUTS_READY, lib.TASK_POUR, False
        self.refuses, self.is_silent, self.gripper_is_silent, self.follows_start = {}, False, False, True

    def _step(self, step):
        start = {name: step.pop(name) for name in ("at_s", "delay_s", "patience_s") if name in step}
        awaited = [self.declare(name, self.scenario) for name in step.pop("awaited", ())]
        if "name" in step:
            self.declare(f"operator.{step['name']}", self.scenario)
            step["name"] = step["name"].encode()
        return {**step, "start": {**start, "awaited": awaited, "awaited_count": len(awaited)}}

    def declare(self, name, owner=None):
        events = ffi.addressof(owner, "events") if owner else self.events
        return lib.events_declare(events, *(part.encode() for part in name.split(".")))

    def raise_event(self, name):
        lib.events_raise(self.events, self.declare(name), self.now_ns * 1e-9)

    def time_of(self, name):
        event = self.events.event[lib.events_find(self.events, name.encode())]
        return event.first_s if event.times else None

    def _receive(self, _context, frame, end_ns):
        message = self.dbc.get_message_by_frame_id(frame.id)
        if message.name not in ("OperatorCommand", "TaskDefine", "ParameterAccess", "GripperCommand"):
            return
        signals = self.dbc.decode_message(frame.id, bytes(frame.data[0 : frame.length]))
        self.sent.append((end_ns * 1e-9, message.name, signals))
        self._answers.append((message.name, signals, ffi.new("can_frame_t *", frame[0])))

    def _send(self, pack, message, gripper=False):
        frame = ffi.new("can_frame_t *")
        assert pack(message, frame) == lib.PROTOCOL_OK
        lib.protocol_protect(ffi.addressof(self.senders, int(gripper)), frame)
        assert lib.bus_send(self.bus, self.gripper if gripper else self.firmware, frame, self.now_ns)

    def _answer(self, name, frame):
        if name == "GripperCommand" and not self.gripper_is_silent:
            command = ffi.new("gripper_command_t *")
            lib.gripper_command_unpack(frame, command)
            state = ffi.new("gripper_state_t *", {"sequence": command.sequence})
            self._send(lib.gripper_state_pack, state, gripper=True)
        elif name == "ParameterAccess" and not self.is_silent:
            access = ffi.new("parameter_access_t *")
            lib.parameter_access_unpack(frame, access)
            value = {"parameter": access.parameter, "sequence": access.sequence, "value": access.value}
            self._send(lib.parameter_value_pack, ffi.new("parameter_value_t *", value))
        elif name in ("OperatorCommand", "TaskDefine") and not self.is_silent:
            command = ffi.new("operator_command_t *")
            define = ffi.new("task_define_t *")
            if name == "TaskDefine":
                lib.task_define_unpack(frame, define)
                number, sequence = lib.COMMAND_DEFINE, define.sequence
                self.task = lib.TASK_CUSTOM
            else:
                lib.operator_command_unpack(frame, command)
                number, sequence = command.command, command.sequence
                self._execute(number, command.task)
            result = self.refuses.get(number, lib.RESULT_ACCEPTED)
            ack = {"command": number, "sequence": sequence, "result": result}
            self._send(lib.command_ack_pack, ffi.new("command_ack_t *", ack))

    def _execute(self, command, task):
        if command == lib.COMMAND_START and self.follows_start:
            self.mode = lib.MODE_COOPERATING
        elif command == lib.COMMAND_STOP:
            self.mode = lib.MODE_READY
        elif command == lib.COMMAND_LATCH:
            self.latched = True
        elif command == lib.COMMAND_SELECT:
            self.task = task

    def run(self, until_s):
        while self.now_ns < round(until_s * 1e9):
            answers, self._answers = self._answers, []
            for name, _signals, frame in answers:
                self._answer(name, frame)
            if self.now_ns % (2 * TICK_NS) == 0:
                status = {"mode": self.mode, "reason": self.reason, "task": self.task, "latched": self.latched}
                self._send(lib.firmware_status_pack, ffi.new("firmware_status_t *", status))
            lib.operator_node_step(self.operator, self.now_ns, self.now_ns + TICK_NS)
            self.now_ns += TICK_NS
            lib.bus_run_until(self.bus, self.now_ns)

    def stop(self):
        lib.operator_node_stop(self.operator)

    @property
    def failure(self):
        text = lib.operator_node_failure(self.operator)
        return None if text == ffi.NULL else ffi.string(text).decode()

    @property
    def script_done(self):
        return lib.operator_node_script_done(self.operator)

    def what(self):
        """Returns one word per frame: its command, task or parameter."""
        words = {
            "OperatorCommand": lambda s: str(s["command"]),
            "TaskDefine": lambda _: "define",
            "ParameterAccess": lambda s: str(s["parameter"]),
            "GripperCommand": lambda s: f"gripper {s['action']}",
        }
        return [words[name](signals) for _, name, signals in self.sent]

    def times(self):
        return [end_s for end_s, *_ in self.sent]


def command(name, **changes):
    kind = lib.OPERATE_COMMAND
    return {"kind": kind, "command": getattr(lib, f"COMMAND_{name.upper()}"), **changes}


def gripper(close, **changes):
    return {"kind": lib.OPERATE_GRIPPER, "close": close, **changes}


SELECT, START = command("select", task=lib.TASK_MIRROR), command("start", at_s=0.5)


def define(form, x_m=0.0):
    unit = {"w": 1.0}
    return {"form": form, "t_task_m": {"x": x_m}, "q_task": unit, "q_inv": unit}


def test_script_runs_in_order_and_on_time(dbc):
    steps = (
        SELECT,
        {**START, "name": "started"},
        gripper(True, awaited=["person.there"], delay_s=0.3, name="closed"),
        command("latch", at_s=3.0),
        gripper(False),
    )
    bench = Bench(dbc, *steps)
    bench.run(2.0)
    assert bench.what() == ["select", "start"]
    assert bench.times()[1] == pytest.approx(0.5, abs=0.0003)
    assert bench.time_of("operator.started") == pytest.approx(0.501, abs=0.0005)
    bench.raise_event("person.there")
    bench.run(2.299)
    assert bench.time_of("operator.closed") is None
    bench.run(4.0)
    assert bench.what() == ["select", "start", "gripper close", "latch", "gripper open"]
    assert bench.times()[2:4] == pytest.approx([2.3, 3.0], abs=0.0003)
    assert bench.time_of("operator.closed") == pytest.approx(2.301, abs=0.0005)
    assert bench.script_done and not lib.operator_node_finished(bench.operator)
    bench.stop()
    bench.run(4.1)
    assert bench.what()[-1] == "stop" and lib.operator_node_finished(bench.operator) and bench.failure is None


def test_parameters_come_first_and_the_command_lines_take_precedence(dbc):
    wished = {"parameter_written": [False] * lib.PARAMETER_COUNT, "parameter_value": [0.0] * lib.PARAMETER_COUNT}
    for number, value in ((lib.PARAMETER_MOTION_SCALE, 0.5), (lib.PARAMETER_DAMPING, 0.25)):
        wished["parameter_written"][number], wished["parameter_value"][number] = True, value
    own = {lib.PARAMETER_MOTION_SCALE: 2.0, lib.PARAMETER_TASK_BLEND_S: 1.5}
    bench = Bench(dbc, SELECT, parameters=own, wishes=wished)
    bench.run(0.3)
    written = [(str(s["parameter"]), s["value"]) for _, name, s in bench.sent if name == "ParameterAccess"]
    assert written == [("damping", 0.25), ("motion_scale", 0.5), ("task_blend_s", 1.5)]
    assert bench.what()[3:] == ["select"] and bench.times()[0] >= 0.01


def test_a_custom_task_replaces_the_first(dbc):
    own, wish = define(lib.TASK_FORM_CONSTANT, 0.1), define(lib.TASK_FORM_MIRRORED, 0.2)
    second = {"kind": lib.OPERATE_DEFINE, "own_task": 0, "at_s": 1.0}
    for first, expected_m in ((SELECT, [0.2, 0.1]), ({**second, "at_s": 0}, [0.2, 0.1])):
        bench = Bench(dbc, first, START, second, own_tasks=[own], wishes={"defines_task": True, "task": wish})
        bench.run(1.5)
        assert bench.what() == ["define", "start", "define"]
        x_m = [signals["t_task_x_m"] for _, name, signals in bench.sent if name == "TaskDefine"]
        assert x_m == pytest.approx(expected_m, abs=1e-6)
    bench = Bench(dbc, START, wishes={"defines_task": True, "task": wish})
    bench.run(1.0)
    assert bench.what() == ["define", "start"]


def test_no_command_before_the_firmware_is_ready(dbc):
    bench = Bench(dbc, SELECT)
    bench.mode, bench.reason = lib.MODE_IDLE, lib.REASON_WAITING_FOR_TRACKER
    bench.run(1.0)
    assert bench.sent == []
    bench.run(3.1)
    why = "mode is still idle (waiting_for_tracker) after 3 s"
    assert bench.failure == f"operator: waiting for mode ready at 3.001 s: {why}"


def test_latch_and_clutch_wait_for_the_cooperation(dbc):
    bench = Bench(dbc, SELECT, START, command("latch", at_s=1.0))
    bench.follows_start = False
    bench.run(2.0)
    assert bench.what() == ["select", "start"] and bench.failure is None
    bench.mode = lib.MODE_COOPERATING
    bench.run(2.1)
    assert bench.what() == ["select", "start", "latch"]


@pytest.mark.parametrize(
    ("event_s", "order"),
    [
        (1.5, ["latch", "gripper close", "clutch"]),
        (2.5, ["latch", "clutch", "gripper close"]),
        (None, ["latch", "clutch"]),
    ],
)
def test_clutch_is_sent_on_time_between_waiting_steps(dbc, event_s, order):
    bench = Bench(
        dbc,
        SELECT,
        START,
        command("latch", at_s=1.0),
        gripper(True, awaited=["person.there"]),
        wishes={"clutch_s": 2.0},
    )
    if event_s is not None:
        bench.run(event_s)
        bench.raise_event("person.there")
    bench.run(3.0)
    assert bench.what()[2:] == order
    assert bench.times()[2 + order.index("clutch")] == pytest.approx(2.0, abs=0.0003)


def test_a_timeout_names_the_event(dbc):
    bench = Bench(dbc, SELECT, command("start", awaited=["person.there"], patience_s=0.8))
    bench.run(3.0)
    assert bench.failure.startswith("operator: command start at 0.8")
    assert bench.failure.endswith(" s: timed out after 0.8 s waiting for person.there")


def test_refusal_and_timeout_are_reported(dbc):
    bench = Bench(dbc, SELECT, START)
    bench.refuses[lib.COMMAND_START] = lib.RESULT_TRACKER_STALE
    bench.follows_start = False
    bench.run(1.0)
    assert bench.failure == "operator: command start at 0.501 s: refused by the firmware: tracker_stale (mode ready)"

    bench = Bench(dbc, gripper(True, at_s=0.5))
    bench.gripper_is_silent = True
    bench.run(1.0)
    assert bench.times() == pytest.approx([0.5, 0.55, 0.6, 0.65], abs=0.0003)
    assert len({s["sequence"] for *_, s in bench.sent}) == 1, "all attempts have one sequence number"
    what = "no answer from the gripper to 4 attempts, 50 ms each"
    assert bench.failure == f"operator: gripper command close at 0.700 s: {what}"


def test_a_gripper_request_without_answer_is_repeated(dbc):
    bench = Bench(dbc, gripper(True, at_s=0.5, name="closed"), gripper(False))
    bench.gripper_is_silent = True
    bench.run(0.57)
    bench.gripper_is_silent = False
    bench.run(1.0)
    assert bench.what() == ["gripper close"] * 3 + ["gripper open"]
    assert bench.time_of("operator.closed") == pytest.approx(0.601, abs=0.0005)


@pytest.mark.parametrize("waits_for", ["an event", "its time", "the cooperation"])
def test_stop_skips_steps_that_have_not_started(dbc, waits_for):
    step = {
        "an event": gripper(True, awaited=["person.there"]),
        "its time": gripper(True, at_s=20.0),
        "the cooperation": command("latch"),
    }[waits_for]
    bench = Bench(dbc, SELECT, START, step, gripper(False))
    bench.follows_start = waits_for != "the cooperation"
    bench.run(2.0)
    bench.stop()
    assert bench.script_done
    bench.run(2.1)
    assert bench.what() == ["select", "start", "stop"]
    assert lib.operator_node_finished(bench.operator) and bench.failure is None


def test_stop_finishes_a_step_in_progress(dbc):
    bench = Bench(dbc, SELECT, gripper(True, at_s=0.5, name="closed"), gripper(False))
    bench.gripper_is_silent = True
    bench.run(0.52)
    bench.stop()
    assert not bench.script_done
    bench.gripper_is_silent = False
    bench.run(0.7)
    assert bench.what() == ["select", "gripper close", "gripper close", "stop"]
    assert bench.time_of("operator.closed") is not None and lib.operator_node_finished(bench.operator)


def test_a_stop_without_effect_fails(dbc):
    bench = Bench(dbc, SELECT, START)
    bench.run(1.0)
    bench.stop()
    bench._execute = lambda *_: None
    bench.run(2.0)
    assert bench.failure.startswith("operator: waiting for mode ready at 1.40")
    assert bench.failure.endswith("s: mode is still cooperating (inputs_ready) after 0.4 s")


def test_it_tracks_whether_the_robot_mirrors(dbc):
    """The node tracks whether the robot mirrors. Table I's mirrored task mirrors until it is latched, and a custom task
    mirrors if its form says so."""
    selected = ((lib.TASK_TELEOP, 0.1), (lib.TASK_MIRROR, 0.4))
    selects = [command("select", task=task, at_s=at_s) for task, at_s in selected]
    bench = Bench(dbc, *selects, START, command("latch", at_s=1.0))
    seen = []
    for until_s in (0.2, 0.45, 0.9, 1.1):
        bench.run(until_s)
        seen.append(lib.operator_node_mirrors(bench.operator))
    assert seen == [False, True, True, False]
    for task in tasks.read():
        bench = Bench(dbc, command("select", task=task.number), START)
        bench.run(0.9)
        assert lib.operator_node_mirrors(bench.operator) == (task.form == "mirrored"), task.name
    for form in (lib.TASK_FORM_CONSTANT, lib.TASK_FORM_MIRRORED):
        bench = Bench(dbc, START, wishes={"defines_task": True, "task": define(form)})
        bench.run(0.9)
        assert lib.operator_node_mirrors(bench.operator) == (form == lib.TASK_FORM_MIRRORED)
