"""The possible transitions of mode and reason are exactly those that the header lists."""

from __future__ import annotations

import itertools

import pytest
from comanip._core import ffi, lib

MODES = [lib.MODE_IDLE, lib.MODE_READY, lib.MODE_COOPERATING, lib.MODE_HOLD, lib.MODE_FAULT]
GOOD = {"drives_fresh": True, "drive_error": False, "tracker_fresh": True, "finite": True}
ALL_INPUTS = [dict(zip(GOOD, values, strict=True)) for values in itertools.product((False, True), repeat=4)]


def inputs(**changes):
    return ffi.new("supervisor_inputs_t *", GOOD | changes)


def supervisor(mode: int):
    result = ffi.new("supervisor_t *")
    lib.supervisor_init(result)
    result.mode = mode
    return result


def updated(mode: int, **changes) -> tuple[int, int]:
    result = supervisor(mode)
    lib.supervisor_update(result, inputs(**changes))
    return result.mode, result.reason


def test_starts_idle_with_reason_boot():
    result = ffi.new("supervisor_t *")
    lib.supervisor_init(result)
    assert (result.mode, result.reason) == (lib.MODE_IDLE, lib.REASON_BOOT)


@pytest.mark.parametrize(
    ("mode", "changes", "after", "reason"),
    [
        (lib.MODE_IDLE, {}, lib.MODE_READY, lib.REASON_INPUTS_READY),
        (lib.MODE_IDLE, {"tracker_fresh": False}, lib.MODE_IDLE, lib.REASON_WAITING_FOR_TRACKER),
        (lib.MODE_IDLE, {"drives_fresh": False}, lib.MODE_IDLE, lib.REASON_WAITING_FOR_DRIVES),
        (lib.MODE_READY, {"tracker_fresh": False}, lib.MODE_IDLE, lib.REASON_WAITING_FOR_TRACKER),
        (lib.MODE_READY, {"drives_fresh": False}, lib.MODE_IDLE, lib.REASON_WAITING_FOR_DRIVES),
        (lib.MODE_COOPERATING, {"tracker_fresh": False}, lib.MODE_HOLD, lib.REASON_TRACKER_STALE),
        (lib.MODE_HOLD, {}, lib.MODE_COOPERATING, lib.REASON_TRACKER_RETURNED),
        (lib.MODE_COOPERATING, {"drives_fresh": False}, lib.MODE_FAULT, lib.REASON_DRIVE_SILENT),
        (lib.MODE_COOPERATING, {"drive_error": True}, lib.MODE_FAULT, lib.REASON_DRIVE_ERROR),
        (lib.MODE_COOPERATING, {"finite": False}, lib.MODE_FAULT, lib.REASON_NOT_FINITE),
        (lib.MODE_HOLD, {"drives_fresh": False, "tracker_fresh": False}, lib.MODE_FAULT, lib.REASON_DRIVE_SILENT),
        (lib.MODE_HOLD, {"drive_error": True, "tracker_fresh": False}, lib.MODE_FAULT, lib.REASON_DRIVE_ERROR),
        (lib.MODE_HOLD, {"finite": False}, lib.MODE_FAULT, lib.REASON_NOT_FINITE),
    ],
)
def test_transition(mode, changes, after, reason):
    assert updated(mode, **changes) == (after, reason)


@pytest.mark.parametrize("mode", [lib.MODE_IDLE, lib.MODE_READY])
@pytest.mark.parametrize("changes", ALL_INPUTS, ids=str)
def test_only_the_start_command_leads_into_motion(mode, changes):
    assert updated(mode, **changes)[0] in (lib.MODE_IDLE, lib.MODE_READY)


@pytest.mark.parametrize("mode", [lib.MODE_COOPERATING, lib.MODE_HOLD])
@pytest.mark.parametrize("changes", ALL_INPUTS, ids=str)
def test_cooperation_continues_with_good_inputs_only(mode, changes):
    bad = changes != GOOD
    assert (updated(mode, **changes)[0] == lib.MODE_COOPERATING) == (not bad)


@pytest.mark.parametrize("changes", ALL_INPUTS, ids=str)
def test_a_fault_is_latched(changes):
    result = supervisor(lib.MODE_FAULT)
    result.reason = lib.REASON_DRIVE_ERROR
    lib.supervisor_update(result, inputs(**changes))
    assert (result.mode, result.reason) == (lib.MODE_FAULT, lib.REASON_DRIVE_ERROR)
    assert lib.supervisor_start(result) == lib.RESULT_WRONG_MODE


@pytest.mark.parametrize("mode", MODES)
def test_start_is_accepted_in_ready_only(mode):
    result = supervisor(mode)
    if mode == lib.MODE_READY:
        assert lib.supervisor_start(result) == lib.RESULT_ACCEPTED
        assert (result.mode, result.reason) == (lib.MODE_COOPERATING, lib.REASON_OPERATOR_START)
    else:
        assert lib.supervisor_start(result) == lib.RESULT_WRONG_MODE
        assert result.mode == mode


@pytest.mark.parametrize("mode", [lib.MODE_COOPERATING, lib.MODE_HOLD])
def test_stop_ends_cooperation(mode):
    result = supervisor(mode)
    assert lib.supervisor_stop(result, inputs()) == lib.RESULT_ACCEPTED
    assert (result.mode, result.reason) == (lib.MODE_READY, lib.REASON_OPERATOR_STOP)


@pytest.mark.parametrize("mode", [lib.MODE_IDLE, lib.MODE_READY])
def test_stop_is_always_accepted_at_rest(mode):
    result = supervisor(mode)
    assert lib.supervisor_stop(result, inputs()) == lib.RESULT_ACCEPTED
    assert result.mode == mode


@pytest.mark.parametrize("changes", [{"drives_fresh": False}, {"drive_error": True}, {"finite": False}], ids=str)
def test_stop_clears_a_fault_without_a_remaining_cause(changes):
    result = supervisor(lib.MODE_FAULT)
    assert lib.supervisor_stop(result, inputs(**changes)) == lib.RESULT_FAULT_PRESENT
    assert result.mode == lib.MODE_FAULT
    assert lib.supervisor_stop(result, inputs()) == lib.RESULT_ACCEPTED
    assert (result.mode, result.reason) == (lib.MODE_IDLE, lib.REASON_FAULT_CLEARED)


def test_stop_categories():
    categories = [lib.supervisor_stop_category(supervisor(mode)) for mode in MODES]
    none = lib.STOP_NONE
    assert categories == [none, none, none, lib.STOP_CATEGORY_2, lib.STOP_CATEGORY_1]
