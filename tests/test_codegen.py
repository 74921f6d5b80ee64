"""The code generator refuses a DBC that the firmware's packers could not carry."""

from __future__ import annotations

import re

import pytest
from cantools.database import load_string
from comanip_dev import codegen
from simulation import REPOSITORY

DBC = codegen.DBC_PATH.read_text()


def changed(signal: str, old: str, new: str):
    line = next(line for line in DBC.splitlines() if line.strip().startswith(f"SG_ {signal} "))
    assert old in line
    return load_string(DBC.replace(line, line.replace(old, new)), "dbc")


def test_a_joint_that_is_scaled_otherwise():
    codegen.check_joints_are_scaled_alike(load_string(DBC, "dbc").get_message_by_name("JointCmd"))
    database = changed("velocity_3_radps", "(0.001,0)", "(0.002,0)")
    with pytest.raises(SystemExit, match="JointCmd: velocity_3_radps is scaled otherwise"):
        codegen.check_joints_are_scaled_alike(database.get_message_by_name("JointCmd"))


def test_a_signal_of_more_bits_than_float32_rounds():
    codegen.schema_header(load_string(DBC, "dbc"))
    database = changed("now_us", "(1,0)", "(0.5,0)")  # 32 bits
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
