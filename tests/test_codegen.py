"""Checks that the code generator refuses an inconsistent schema, so that a mistake in it is found when the firmware is
built and not when it runs."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys

import pytest
from cantools.database import load_string
from comanip import parameters, tasks
from comanip_dev import codegen
from comanip_dev.schema import readers
from simulation import REPOSITORY

DBC = codegen.DBC_PATH.read_text()


def changed(signal: str, old: str, new: str):
    line = next(line for line in DBC.splitlines() if line.strip().startswith(f"SG_ {signal} "))
    assert old in line
    return load_string(DBC.replace(line, line.replace(old, new)), "dbc")


def test_a_joint_with_a_different_scale():
    codegen.check_joints_are_scaled_alike(load_string(DBC, "dbc").get_message_by_name("JointCmd"))
    database = changed("velocity_3_radps", "(0.001,0)", "(0.002,0)")
    with pytest.raises(SystemExit, match="JointCmd.velocity_3_radps: expected the length and scale"):
        codegen.check_joints_are_scaled_alike(database.get_message_by_name("JointCmd"))


def test_a_signal_with_more_bits_than_float32_holds():
    codegen.schema_header(load_string(DBC, "dbc"))
    database = changed("now_us", "(1,0)", "(0.5,0)")  # a 32-bit signal
    with pytest.raises(SystemExit, match="TickTrace.now_us: raw values to 4294967295, expected at most 8388608"):
        codegen.schema_header(database)


def test_packing_writes_each_byte_before_it_is_ored_into():
    source = (REPOSITORY / "build" / "generated" / "comanip_dbc.c").read_text()
    messages = load_string(DBC, "dbc").messages
    bodies = re.findall(r"\nint comanip_\w+_pack\(\n.*?\n}\n", source, flags=re.DOTALL)
    assert len(bodies) == len(messages)
    for message, body in zip(messages, bodies, strict=True):
        writes = re.findall(r"dst_p\[(\d+)\] (\|?=) ", body)
        first = {int(byte): operator for byte, operator in reversed(writes)}
        assert first == dict.fromkeys(range(message.length), "="), message.name
        assert sum(operator == "=" for _, operator in writes) == message.length


def test_multiplexed_signals_are_refused():
    body = "    memset(&dst_p[0], 0, 8);\n    switch (src_p->kind) {\n    }\n\n    return (8);\n"
    with pytest.raises(SystemExit, match="multiplexed"):
        codegen.write_each_byte_once(body)


# ---- a mistake in the schema ends the build with a message of one line


@pytest.fixture
def schema(tmp_path):
    shutil.copytree(codegen.SCHEMA, tmp_path / "schema")
    return tmp_path / "schema"


def edit(path, pattern: str, new: str) -> None:
    text, count = re.subn(pattern, new, path.read_text(), count=1, flags=re.DOTALL | re.MULTILINE)
    assert count == 1, f"{pattern} is not in {path.name}"
    path.write_text(text)


def generated(schema) -> None:
    codegen.main(schema.parent / "generated", schema)


PARAMETER_MISTAKES = {
    "no range": (r"^range = \[0, 500\]\n", "", "parameter 'gain_*_per_s': no range"),
    "no unit": (r'^unit = "rad/s\^2"\n', "", "parameter 'acceleration_limit_radps2': no unit"),
    "two with one number": (r"^number = 17$", "number = 16", "number 16 is already used by 'damping'"),
    "a vector over another": (r"^number = 16$", "number = 15", "number 15 is already used by 'weight_dual_z'"),
    "a retired number": (r"^retired = \[\]", "retired = [36]", "number 36 is retired"),
    "one name twice": (r'^name = "error_frame"', 'name = "damping"', "'damping' is used twice"),
    "default out of range": (r"^default = 0.005$", "default = 0.06", "default 0.06"),
    "a part as integer": (r'(name = "error_frame".*?)default = 1$', r"\1default = 0.5", "of type integer"),
    "range upside down": (r"^range = \[1, 70\]", "range = [70, 1]", "expected least < greatest"),
    "unknown key": (r"^unit = \"rad/s\^2\"", 'unit = "rad/s^2"\nhelp = "x"', "unknown key 'help'"),
    "a number too many": (r"^number = 42$", "number = 64", "number 64: expected 0 to 63"),
}
TASK_MISTAKES = {
    "two with one number": (r"^number = 2$", "number = 1", "task 'mirror': number 1 is already used by 'teleop'"),
    "the custom task's number": (r"^number = 2$", "number = 3", "except 3, the custom task"),
    "no unit quaternion": (r"^q_task = \[1, 0, 0, 0\]", "q_task = [1, 1, 0, 0]", "q_task has norm 1.41421, expected 1"),
    "unknown form": (r'^form = "mirrored"', 'form = "twisted"', "form 'twisted': expected one of constant, mirrored"),
    "no form": (r'^form = "mirrored"\n', "", "task 'mirror': keys"),
}
DBC_MISTAKES = {
    "another value table on classic CAN": (
        r'^VAL_ 1040 mode 0 "idle"',
        'VAL_ 1040 mode 0 "off"',
        "table of FirmwareStatus",
    ),
    "a part of nothing": (
        r'^BA_ "PartOf" BO_ 1040 "FirmwareStatus"',
        'BA_ "PartOf" BO_ 1040 "Nobody"',
        "PartOf 'Nobody'",
    ),
    "a received frame that TickTrace lacks": (r"^ SG_ task_define_counter [^\n]*\n", "", "TickTrace has counters of"),
    "a Data ID of two frames": (
        r'^BA_ "E2EDataId" BO_ 1041 2;',
        'BA_ "E2EDataId" BO_ 1041 1;',
        "ClassicCommandAck: E2EDataId 1 is already used by ClassicFirmwareStatus",
    ),
    "a parameter's name": (r'"damping"', '"dampening"', "make schema"),
    "a signal of no message": (r"^( SG_) t_high ", r"\1 t_highest ", "has no such signal"),
}


@pytest.mark.parametrize("kind", PARAMETER_MISTAKES)
def test_a_wrong_parameter_description(schema, kind):
    pattern, new, complaint = PARAMETER_MISTAKES[kind]
    edit(schema / "parameters.toml", pattern, new)
    with pytest.raises(SystemExit, match=re.escape(complaint)):
        generated(schema)


@pytest.mark.parametrize("kind", TASK_MISTAKES)
def test_a_wrong_task_description(schema, kind):
    pattern, new, complaint = TASK_MISTAKES[kind]
    edit(schema / "tasks.toml", pattern, new)
    with pytest.raises(SystemExit, match=re.escape(complaint)):
        generated(schema)


@pytest.mark.parametrize("kind", DBC_MISTAKES)
def test_a_wrong_frame_description(schema, kind):
    pattern, new, complaint = DBC_MISTAKES[kind]
    edit(schema / "comanip.dbc", pattern, new)
    with pytest.raises(SystemExit, match=re.escape(complaint)):
        generated(schema)


def test_a_frame_without_a_reader(schema):
    path = schema / "comanip.dbc"
    message = re.search(r"^BO_ 528 GripperCommand.*?\n\n", path.read_text(), re.DOTALL | re.MULTILINE)[0]
    path.write_text(path.read_text().replace(message, message.replace(" Gripper\n", " Vector__XXX\n")))
    with pytest.raises(SystemExit, match="GripperCommand: no reader"):
        generated(schema)


PROBE = """BO_ {frame_id} Probe: 8 Operator
 SG_ e2e_crc : 0|16@1+ (1,0) [0|65535] "" Firmware
 SG_ e2e_counter : 16|8@1+ (1,0) [0|255] "" Firmware
 SG_ depth_m : 24|16@1+ (0.001,0) [0|65.535] "m" Firmware

BO_ 528 GripperCommand"""


@pytest.fixture
def with_a_frame(schema):
    """Adds to the schema a frame that the firmware receives, and adds the frame's counter to TickTrace."""
    path, messages = schema / "comanip.dbc", {message.name: message for message in load_string(DBC, "dbc").messages}
    used_ids = {message.frame_id for message in messages.values()}
    frame_id = next(number for number in range(515, 1024) if number not in used_ids)
    edit(path, r"^BO_ 528 GripperCommand", PROBE.format(frame_id=frame_id))
    trace = messages["TickTrace"]
    bits = trace.get_signal_by_name("received").length
    free = max(signal.start + signal.length for signal in trace.signals)
    counter = f' SG_ probe_counter : {free}|8@1+ (1,0) [0|255] "" Operator'
    edit(path, rf"^( SG_ received : \d+\|){bits}(.*?\n)", rf"\g<1>{bits + 1}\2{counter}\n")  # in TickTrace
    edit(path, rf"^( SG_ received : \d+\|){bits}", rf"\g<1>{bits + 1}")  # in ClassicTickTraceAge
    generated(schema)
    return schema


def compile_inputs(schema, more: str = ""):
    source = (
        (REPOSITORY / "firmware" / "controller_inputs.c")
        .read_text()
        .replace("static void take_task_define", more + "static void take_task_define")
    )
    flags = ["-std=c11", "-Werror=implicit-function-declaration", "-fsyntax-only", f"-I{schema.parent / 'generated'}"]
    command = ["gcc", *flags, f"-I{REPOSITORY / 'firmware'}", "-x", "c", "-"]
    return subprocess.run(command, input=source, capture_output=True, text=True, check=False)


def test_a_frame_for_the_firmware_without_a_reader_does_not_compile(with_a_frame):
    done = compile_inputs(with_a_frame)
    assert done.returncode != 0 and "take_probe" in done.stderr
    reader = """static void take_probe(controller_t *self, const received_t *received) {
    probe_t probe;
    probe_unpack(received->frame, &probe);
    self->finite = probe.depth_m < 1.0f;
}
"""
    done = compile_inputs(with_a_frame, reader)
    assert done.returncode == 0, done.stderr


def test_a_frame_for_others_that_nobody_reads():
    messages = load_string(DBC, "dbc").messages
    simulator = "clearance_unpack("
    others = {message.name for message in messages} - {"Clearance", "FirmwareHeartbeat"}
    tools = " ".join(f'"{name}"' for name in others) + " FRAME_FIRMWARE_HEARTBEAT"
    assert list(readers.without_reader(messages, simulator, tools)) == []
    assert list(readers.without_reader(messages, "", tools)) == ["Clearance"]
    assert list(readers.without_reader(messages, simulator, tools.replace('"CommandAck"', ""))) == ["CommandAck"]


def test_a_parameter_that_the_firmware_does_not_use():
    described = parameters.read()
    firmware = "".join(f"PARAMETER_{vector.upper()};\n" for vector in {parameter.vector for parameter in described})
    assert readers.unused(described, firmware) == []
    assert readers.unused(described, firmware.replace("PARAMETER_WEIGHT;", "PARAMETER_WEIGHTS;")) == ["weight"]


def test_the_schema_as_it_is_and_what_make_schema_writes(schema):
    generated(schema)
    before = (schema / "comanip.dbc").read_bytes()
    codegen.update_schema(schema)
    assert (schema / "comanip.dbc").read_bytes() == before
    names = tasks.names(schema / "tasks.toml")
    number = max(names) + 1
    edit(schema / "tasks.toml", r"\Z", TASK.format(number=number))
    with pytest.raises(SystemExit, match="make schema"):
        generated(schema)
    codegen.update_schema(schema)
    generated(schema)
    message = load_string((schema / "comanip.dbc").read_text(), "dbc").get_message_by_name("FirmwareStatus")
    assert message.get_signal_by_name("task").choices == names | {number: "of_a_test"}


TASK = """
[[task]]
number = {number}
name = "of_a_test"
form = "mirrored"
t_task_m = [0, 0, 0.1]
q_task = [0, 1, 0, 0]
q_inv = [0, 1, 0, 0]
meaning = "A test's."
"""


def test_a_mistake_is_one_line_of_the_build(tmp_path):
    """The generator, called as make calls it, reports a mistake in a single line."""
    clone = tmp_path / "clone"
    shutil.copytree(REPOSITORY / "host_tools", clone / "host_tools", symlinks=True)
    shutil.copytree(REPOSITORY / "firmware", clone / "firmware")
    edit(clone / "firmware" / "schema" / "parameters.toml", r"^range = \[0, 500\]\n", "")
    done = subprocess.run(
        [sys.executable, "-m", "comanip_dev.codegen", tmp_path / "out"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        env={"PYTHONPATH": f"{clone / 'host_tools'}:{clone / 'host_tools' / 'development'}"},
    )
    assert done.returncode != 0 and done.stderr.count("\n") == 1 and "no range" in done.stderr
