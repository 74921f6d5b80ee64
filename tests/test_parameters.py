"""The parameter table agrees with the DBC, and invalid values are refused."""

from __future__ import annotations

import math

import numpy as np
import oracle
import pytest
from comanip import core
from comanip._core import ffi, lib

COUNT = lib.PARAMETER_COUNT
ALL = range(COUNT)


@pytest.fixture
def parameters():
    fresh = ffi.new("parameters_t *")
    lib.parameters_set_defaults(fresh)
    return fresh


def name(parameter: int) -> str:
    return ffi.string(lib.parameter_table[parameter].name).decode()


@pytest.mark.parametrize("message", ["ParameterValue", "ParameterAccess"])
def test_names_and_numbers_match_the_dbc(dbc, message):
    choices = dbc.get_message_by_name(message).get_signal_by_name("parameter").choices
    assert {number: str(choice) for number, choice in choices.items()} == {number: name(number) for number in ALL}


@pytest.mark.parametrize("parameter", ALL, ids=name)
def test_range(parameters, parameter):
    """The default and both ends of the range are accepted. Values outside the range, NaN and infinities are refused and
    change nothing."""
    row = lib.parameter_table[parameter]
    assert row.minimum <= row.default_value <= row.maximum
    assert parameters.value[parameter] == row.default_value
    for value in (row.minimum, row.maximum):
        assert lib.parameters_set(parameters, parameter, value) == lib.RESULT_ACCEPTED
        assert parameters.value[parameter] == value
    below, above = (
        np.nextafter(np.float32(end), np.float32(way)) for end, way in ((row.minimum, -1e9), (row.maximum, 1e9))
    )
    for value in (below, above, math.nan, math.inf, -math.inf, 3e9, -3e9):
        assert lib.parameters_set(parameters, parameter, value) == lib.RESULT_OUT_OF_RANGE
        assert parameters.value[parameter] == row.maximum


@pytest.mark.parametrize("parameter", [p for p in ALL if lib.parameter_table[p].integer], ids=name)
def test_whole_numbers_only(parameters, parameter):
    assert lib.parameters_set(parameters, parameter, 0.5) == lib.RESULT_OUT_OF_RANGE


@pytest.mark.parametrize("parameter", [COUNT, COUNT + 1, 255])
def test_unknown_parameter(parameters, parameter):
    before = bytes(ffi.buffer(parameters))
    assert lib.parameters_set(parameters, parameter, 1.0) == lib.RESULT_UNKNOWN_PARAMETER
    assert bytes(ffi.buffer(parameters)) == before


def test_a_write_changes_one_parameter_only(parameters):
    for parameter in ALL:
        before = list(parameters.value)
        assert lib.parameters_set(parameters, parameter, lib.parameter_table[parameter].maximum) == lib.RESULT_ACCEPTED
        assert [i for i in ALL if parameters.value[i] != before[i]] in ([parameter], [])


def write(parameters, first: int, values) -> None:
    for offset, value in enumerate(values):
        assert lib.parameters_set(parameters, first + offset, value) == lib.RESULT_ACCEPTED


def test_view_of_the_control_law(parameters):
    gain, weight = [float(i) for i in range(1, 9)], [float(i) for i in range(11, 19)]
    write(parameters, lib.PARAMETER_GAIN_PER_S, gain)
    write(parameters, lib.PARAMETER_WEIGHT, weight)
    write(parameters, lib.PARAMETER_DAMPING, [0.5])
    write(parameters, lib.PARAMETER_ERROR_FRAME, [0])
    config = ffi.new("differential_ik_config_t *")
    lib.parameters_differential_ik(parameters, config)
    assert (list(config.gain_per_s), list(config.weight), config.damping) == (gain, weight, 0.5)
    assert config.error_frame == lib.ERROR_FRAME_TORSO
    write(parameters, lib.PARAMETER_ERROR_FRAME, [1])
    lib.parameters_differential_ik(parameters, config)
    assert config.error_frame == lib.ERROR_FRAME_TARGET


def test_view_of_position_priority(parameters):
    write(parameters, lib.PARAMETER_FOLLOWING_GAIN_PER_S, [20])
    write(parameters, lib.PARAMETER_ORIENTATION_WEIGHT_M2, [2**-12])
    config = ffi.new("position_priority_config_t *")
    lib.parameters_position_priority(parameters, config)
    assert (config.gain_per_s, config.orientation_weight_m2) == (20, 2**-12)


def test_view_of_the_joint_limits(parameters):
    write(parameters, lib.PARAMETER_GAIN_PER_S, [1, 2, 3, 77, 5, 6, 7, 8])
    write(parameters, lib.PARAMETER_SPEED_FRACTION, [0.5])
    write(parameters, lib.PARAMETER_ACCELERATION_LIMIT_RADPS2, [12])
    write(parameters, lib.PARAMETER_COMMAND_DELAY_S, [0.03125])
    config = ffi.new("joint_limits_config_t *")
    lib.parameters_joint_limits(parameters, core.Arm.named("hoap3_right").table, 0.001, config)
    assert (config.speed_fraction, config.acceleration_max_radps2, config.command_delay_s) == (0.5, 12, 0.03125)
    assert (config.tick_s, config.approach_gain_per_s) == (np.float32(0.001), 35)
    write(parameters, lib.PARAMETER_PREDICTION, [0])
    lib.parameters_joint_limits(parameters, core.Arm.named("hoap3_right").table, 0.001, config)
    assert config.approach_gain_per_s == 77  # the gain of control law (4)
    for plan in list(config.plan)[
        :4
    ]:  # prepared step sizes in units of 1 mrad/s: 12 rad/s^2 over 1 ms, and 10,000 rad/s^3 over 1 ms squared
        assert (plan.change_max_steps, plan.jerk_steps) == (12, 10)


def test_view_of_the_cooperation(parameters):
    config = ffi.new("cooperation_config_t *")
    lib.parameters_cooperation(parameters, config)
    q = config.tracker_rotation
    assert np.abs(np.array([q.w, q.x, q.y, q.z]) - oracle.EQUATION_9).max() < 1e-6  # the paper's mount is the default
    rotation_vector = [0.3, -1.2, 0.7]
    write(parameters, lib.PARAMETER_TRACKER_ROTATION_RAD, rotation_vector)
    write(parameters, lib.PARAMETER_START_OFFSET_M, [0.25, 0.5, -0.75])
    write(parameters, lib.PARAMETER_MOTION_SCALE, [0.5])
    lib.parameters_cooperation(parameters, config)
    q, offset = config.tracker_rotation, config.start_offset_m
    expected = oracle.rotation(rotation_vector, np.linalg.norm(rotation_vector))
    assert np.abs(np.array([q.w, q.x, q.y, q.z]) - expected).max() < 1e-6
    assert (offset.x, offset.y, offset.z, config.motion_scale) == (0.25, 0.5, -0.75, 0.5)


def test_view_of_the_marker(parameters):
    rotation_vector, t = [0.3, -1.2, 0.7], [0.25, 0.5, -0.75]
    write(parameters, lib.PARAMETER_MARKER_TO_HAND_ROTATION_RAD, rotation_vector)
    write(parameters, lib.PARAMETER_MARKER_TO_HAND_TRANSLATION_M, t)
    pose = ffi.new("dual_quaternion_t *", lib.pose_to_dual_quaternion(lib.parameters_marker_to_hand(parameters)))
    got = np.frombuffer(ffi.buffer(pose), np.float32)
    assert np.abs(got - oracle.pose(oracle.rotation(rotation_vector, np.linalg.norm(rotation_vector)), t)).max() < 1e-6
