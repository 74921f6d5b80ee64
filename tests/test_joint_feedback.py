"""Checks the feedback from the drives: it is fresh only if the state of every joint is, and an error of one drive
counts as an error of the arm."""

from __future__ import annotations

import pytest
from comanip._core import ffi, lib

WRAP = 2**32
TIMEOUT_US = 1000 * lib.frame_table[lib.FRAME_JOINT_STATE0].timeout_ms


def feedback(times_us, **state):
    feedback_state = ffi.new("joint_feedback_t *")
    lib.joint_feedback_init(feedback_state, TIMEOUT_US)
    message = ffi.new("joint_state_t *", state)
    for joint, time_us in enumerate(times_us):
        lib.joint_feedback_receive(feedback_state, joint, message, time_us % WRAP)
    return feedback_state


def is_fresh(feedback_state, count: int, now_us: int) -> bool:
    return lib.joint_feedback_check_fresh(feedback_state, count, now_us % WRAP)


@pytest.mark.parametrize("zero", [0, WRAP - 1000, WRAP - TIMEOUT_US])
@pytest.mark.parametrize("count", range(1, 9))
def test_fresh_within_the_timeout_of_every_joint(zero, count):
    for oldest in range(count):
        feedback_state = feedback([zero + (0 if joint == oldest else 500) for joint in range(count)])
        assert is_fresh(feedback_state, count, zero + TIMEOUT_US)
        assert not is_fresh(feedback_state, count, zero + TIMEOUT_US + 1)


def test_a_joint_that_never_answered_is_not_fresh():
    assert not is_fresh(feedback([]), 4, 0)
    assert not is_fresh(feedback([0, 0, 0]), 4, 0)
    assert is_fresh(feedback([0, 0, 0]), 3, 0)


@pytest.mark.parametrize(
    "error", [lib.DRIVE_ERROR_COMMAND_TIMEOUT, lib.DRIVE_ERROR_OVER_TEMPERATURE, lib.DRIVE_ERROR_ENCODER]
)
def test_one_drives_error_is_the_arms(error):
    for joint in range(4):
        feedback_state = feedback([0] * 4)
        assert not lib.joint_feedback_has_error(feedback_state, 4)
        lib.joint_feedback_receive(feedback_state, joint, ffi.new("joint_state_t *", {"error": error}), 0)
        assert lib.joint_feedback_has_error(feedback_state, 4)
        assert not lib.joint_feedback_has_error(feedback_state, joint)


def test_positions_are_the_last_received():
    feedback_state = feedback([0] * 4, position_rad=0.25)
    lib.joint_feedback_receive(feedback_state, 2, ffi.new("joint_state_t *", {"position_rad": -1.5}), 10)
    assert list(feedback_state.position_rad)[:4] == [0.25, 0.25, -1.5, 0.25]


def test_an_answer_does_not_become_fresh_again_when_the_clock_wraps():
    """A stale answer does not become fresh again when the 32-bit microsecond clock wraps after 71 minutes. The firmware
    checks the age in every tick, this test only every 10 s."""
    feedback_state = feedback([0] * 4)
    for now_us in range(10_000_000, WRAP, 10_000_000):
        assert not is_fresh(feedback_state, 4, now_us)
    assert not is_fresh(feedback_state, 4, WRAP + 100)
