"""The code generator refuses a DBC that the firmware's packers could not carry."""

from __future__ import annotations

import pytest
from cantools.database import load_string
from comanip import codegen

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
