"""The possible transitions of mode and reason are exactly those that the header lists."""

from __future__ import annotations

import itertools

import pytest
from comanip._core import ffi, lib

MODES = [lib.MODE_IDLE, lib.MODE_READY, lib.MODE_COOPERATING, lib.MODE_HOLD, lib.MODE_FAULT]
REASON_OF = {
    lib.JOINT_WATCH_SILENT: lib.REASON_DRIVE_SILENT,
    lib.JOINT_WATCH_ERROR: lib.REASON_DRIVE_ERROR,
    lib.JOINT_WATCH_OUT_OF_RANGE: lib.REASON_JOINT_OUT_OF_RANGE,
    lib.JOINT_WATCH_DEVIATES: lib.REASON_JOINT_DEVIATES,
    lib.JOINT_WATCH_WRONG_MODE: lib.REASON_DRIVE_MODE,
}
FINDINGS = [lib.JOINT_WATCH_OK, *REASON_OF]
GOOD = {
    "finding": lib.JOINT_WATCH_OK, "in_range": True, "at_rest": True, "powered": False, "tracker_fresh": True,
    "finite": True,
}  # fmt: skip
ALL_INPUTS = [
    dict(zip(GOOD, values, strict=True)) for values in itertools.product(FINDINGS, *[(False, True)] * (len(GOOD) - 1))
]


def inputs(**changes):
    values = GOOD | changes
    joints = {name: values.pop(name) for name in ("finding", "in_range", "at_rest")}
    return ffi.new("supervisor_inputs_t *", values | {"joints": joints})


def supervisor(mode: int, reason: int = lib.REASON_BOOT):
    result = ffi.new("supervisor_t *")
    lib.supervisor_init(result)
    result.mode, result.reason = mode, reason
    return result


def updated(mode: int, **changes) -> tuple[int, int]:
    result = supervisor(mode)
    lib.supervisor_update(result, inputs(**changes))
    return result.mode, result.reason


def cause(changes: dict) -> int | None:
    """Returns the reason of the fault that these inputs cause in a powered arm."""
    return lib.REASON_NOT_FINITE if not changes["finite"] else REASON_OF.get(changes["finding"])


def test_starts_idle_with_reason_boot():
    result = ffi.new("supervisor_t *")
    lib.supervisor_init(result)
    assert (result.mode, result.reason) == (lib.MODE_IDLE, lib.REASON_BOOT)


@pytest.mark.parametrize("changes", ALL_INPUTS, ids=str)
def test_every_transition_while_idle_or_ready(changes):
    """Only the start command leads into motion, and a fault while the arm still has power after a stop is latched."""
    for mode in (lib.MODE_IDLE, lib.MODE_READY):
        if changes["powered"] and cause(changes) is not None:
            expected = lib.MODE_FAULT, cause(changes)
        elif changes["finding"] != lib.JOINT_WATCH_OK:
            expected = lib.MODE_IDLE, lib.REASON_WAITING_FOR_DRIVES
        elif not changes["tracker_fresh"]:
            expected = lib.MODE_IDLE, lib.REASON_WAITING_FOR_TRACKER
        else:
            expected = lib.MODE_READY, lib.REASON_INPUTS_READY if mode == lib.MODE_IDLE else lib.REASON_BOOT
        assert updated(mode, **changes) == expected


@pytest.mark.parametrize("changes", ALL_INPUTS, ids=str)
def test_every_transition_while_cooperating_or_in_hold(changes):
    for mode in (lib.MODE_COOPERATING, lib.MODE_HOLD):
        if cause(changes) is not None:
            expected = lib.MODE_FAULT, cause(changes)
        elif changes["tracker_fresh"]:
            returned = lib.REASON_TRACKER_RETURNED if mode == lib.MODE_HOLD else lib.REASON_BOOT
            expected = lib.MODE_COOPERATING, returned
        else:
            stale = lib.REASON_TRACKER_STALE if mode == lib.MODE_COOPERATING else lib.REASON_BOOT
            expected = lib.MODE_HOLD, stale
        assert updated(mode, **changes) == expected


@pytest.mark.parametrize("changes", ALL_INPUTS, ids=str)
def test_a_fault_is_left_by_an_acknowledgement_at_standstill_only(changes):
    result, given = supervisor(lib.MODE_FAULT, lib.REASON_JOINT_DEVIATES), inputs(**changes)
    lib.supervisor_update(result, given)
    assert lib.supervisor_start(result, given) == lib.RESULT_WRONG_MODE
    assert lib.supervisor_stop(result) == lib.RESULT_NOT_ACKNOWLEDGED
    assert (result.mode, result.reason) == (lib.MODE_FAULT, lib.REASON_JOINT_DEVIATES)
    answer = lib.supervisor_acknowledge(result, given)
    if cause(changes) is not None:
        assert answer == lib.RESULT_FAULT_PRESENT
    elif changes["powered"] or not changes["at_rest"]:
        assert answer == lib.RESULT_NOT_AT_REST
    else:
        assert (answer, result.mode, result.reason) == (lib.RESULT_ACCEPTED, lib.MODE_IDLE, lib.REASON_FAULT_CLEARED)
        return
    assert (result.mode, result.reason) == (lib.MODE_FAULT, lib.REASON_JOINT_DEVIATES)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("at_rest", [False, True])
@pytest.mark.parametrize("in_range", [False, True])
def test_start_is_accepted_in_ready_at_rest_and_in_range(mode, at_rest, in_range):
    result = supervisor(mode)
    answer = lib.supervisor_start(result, inputs(at_rest=at_rest, in_range=in_range))
    if mode != lib.MODE_READY:
        assert answer == lib.RESULT_WRONG_MODE
    elif not in_range:
        assert answer == lib.RESULT_JOINT_OUT_OF_RANGE
    elif not at_rest:
        assert answer == lib.RESULT_NOT_AT_REST
    else:
        assert (answer, result.mode) == (lib.RESULT_ACCEPTED, lib.MODE_COOPERATING)
        assert result.reason == lib.REASON_OPERATOR_START
        return
    assert (result.mode, result.reason) == (mode, lib.REASON_BOOT)


@pytest.mark.parametrize("mode", [lib.MODE_COOPERATING, lib.MODE_HOLD])
def test_stop_ends_cooperation(mode):
    result = supervisor(mode)
    assert lib.supervisor_acknowledge(result, inputs()) == lib.RESULT_WRONG_MODE
    assert result.mode == mode
    assert lib.supervisor_stop(result) == lib.RESULT_ACCEPTED
    assert (result.mode, result.reason) == (lib.MODE_READY, lib.REASON_OPERATOR_STOP)


@pytest.mark.parametrize("mode", [lib.MODE_IDLE, lib.MODE_READY])
def test_stop_and_acknowledge_change_nothing_at_rest(mode):
    result = supervisor(mode)
    assert lib.supervisor_stop(result) == lib.RESULT_ACCEPTED
    assert lib.supervisor_acknowledge(result, inputs(at_rest=False, powered=True)) == lib.RESULT_ACCEPTED
    assert (result.mode, result.reason) == (mode, lib.REASON_BOOT)


def test_stop_categories():
    categories = [lib.supervisor_stop_category(supervisor(mode)) for mode in MODES]
    none = lib.STOP_NONE
    assert categories == [none, none, none, lib.STOP_CATEGORY_2, lib.STOP_CATEGORY_1]
