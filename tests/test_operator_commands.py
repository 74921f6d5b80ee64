"""`comanip task` and `comanip param` with the C core on a virtual bus: commands are acknowledged, values are verified,
and refusals name their reason."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from bus_log import DBC
from comanip._core import ffi, lib
from comanip.bus.frame import Frame, protected
from comanip.bus.operator_client import OperatorClient
from comanip.bus.transport import Profile
from comanip.errors import ToolError
from comanip_command import WRONG_USE, call, call_here, require_refusal
from e2e import p05
from hub import wait_until
from live_firmware import CHANNEL, firmware

BUS = ("-i", "virtual", "-c", CHANNEL)
PARAMETERS = [ffi.string(lib.parameter_table[i].name).decode() for i in range(lib.PARAMETER_COUNT)]


@pytest.fixture
def live():
    with firmware() as running:
        yield running


@pytest.fixture
def comanip(monkeypatch, capsys):
    return lambda *arguments: call_here(monkeypatch, capsys, *arguments)


def require_refused(outcome: tuple[int, str, str], *words: str) -> None:
    status, out, err = outcome
    assert (status, out) == (WRONG_USE, "")
    assert err.startswith("comanip: ") and err.count("\n") == 1
    assert all(word in err for word in words), err


def test_a_session(live, comanip):
    """After a session the firmware is in the expected state, and all requests on the bus are valid according to the E2E
    reference implementation."""
    core = live.bench.controller
    assert comanip("task", "select", "mirror", *BUS) == (0, "select mirror: accepted\n", "")
    assert core.task_id == lib.TASK_MIRROR
    assert comanip("task", "start", *BUS)[0] == 0
    assert core.supervisor.mode == lib.MODE_COOPERATING
    assert comanip("task", "latch", *BUS)[0] == 0
    assert core.cooperation.latched
    assert comanip("task", "clutch", *BUS)[0] == 0
    require_refused(comanip("param", "set", "motion_scale", 0.5, *BUS), "motion_scale", "wrong_mode")
    assert comanip("task", "stop", *BUS)[0] == 0
    assert core.supervisor.mode == lib.MODE_READY
    for message in live.received:
        layout = DBC.get_message_by_frame_id(message.arbitration_id)
        assert p05.e2e_p05_check(bytes(message.data), layout.dbc.attributes["E2EDataId"].value), layout.name
        assert message.is_fd and message.bitrate_switch and len(message.data) == layout.length


def test_refusals_are_named(live, comanip):
    require_refused(comanip("task", "latch", *BUS), "latch", "wrong_mode")
    live.bench.hand = None
    live.wait_for_mode(lib.MODE_IDLE)
    require_refused(comanip("task", "start", *BUS), "start", "wrong_mode")
    require_refused(comanip("param", "save", *BUS), "save", "not_supported", "--parameters")
    live.bench.store_result = lib.RESULT_STORE_FAILED
    require_refused(comanip("param", "save", *BUS), "save", "store_failed", "could not write")
    require_refused(comanip("param", "set", "stale_periods", 1000, *BUS), "stale_periods", "out_of_range", "2.5")
    require_refused(comanip("param", "set", "no_such", 1, *BUS), "no_such", "motion_scale")
    require_refused(comanip("param", "set", "damping", 1e39, *BUS), "1e+39", "float32")
    require_refused(comanip("task", "select", "juggle", *BUS), "juggle", "pour, teleop, mirror")


def test_an_unstable_combination_of_parameters_is_named(live, comanip):
    """Parameters that are unstable in combination are named with their values when they would take effect, not when one
    of them is written."""
    for name, value in (("gain_x_per_s", 400), ("gain_dual_z_per_s", 450)):
        assert comanip("param", "set", name, value, *BUS)[0] == 0
    words = ("parameters_unstable", "gain_x_per_s = 400, gain_dual_z_per_s = 450;")
    require_refused(comanip("task", "start", *BUS), "start", *words)
    require_refused(comanip("param", "save", *BUS), "save", *words)
    for name in ("gain_x_per_s", "gain_dual_z_per_s"):
        assert comanip("param", "set", name, 35, *BUS)[0] == 0
    assert comanip("task", "start", *BUS)[0] == 0


def test_parameters_are_written_and_read_back(live, comanip):
    values = live.bench.controller.parameters.value
    assert comanip("param", "set", "tracker_rotation_y_rad", *BUS, "--", "-0.1")[0] == 0
    assert values[lib.PARAMETER_TRACKER_ROTATION_RAD + 1] == np.float32(-0.1)
    status, out, _ = comanip("param", "get", "tracker_rotation_y_rad", *BUS)
    assert (status, float(out)) == (0, pytest.approx(-0.1, abs=1e-7))
    status, out, _ = comanip("param", "list", *BUS)
    assert status == 0
    rows = {line.split()[0]: [float(word) for word in line.split()[1:5]] for line in out.splitlines()[1:]}
    assert list(rows) == PARAMETERS
    for i, name in enumerate(PARAMETERS):
        row = lib.parameter_table[i]
        assert rows[name] == pytest.approx([values[i], row.minimum, row.maximum, row.default_value], rel=1e-6)


def test_parameters_are_saved_once_even_if_the_store_is_slow(live, comanip, monkeypatch):
    """If a save takes longer than the client waits for an answer, the request is repeated with the same sequence
    number, and the parameters are saved only once."""
    monkeypatch.setattr("comanip.bus.operator_client.SAVE_S", 0.0)
    live.bench.store_result = lib.RESULT_ACCEPTED
    live.bench.store_ticks = 10**9

    stored: list = []

    def end_when_repeated() -> None:
        wait_until(lambda: len(live.received) >= 3, "three requests")
        # copied before the save ends, because a request that arrives afterwards would start another save
        stored.extend(live.bench.stored)
        live.bench.store_until = 0

    ending = threading.Thread(target=end_when_repeated)
    ending.start()
    status, out, _ = comanip("param", "save", *BUS)
    ending.join()
    assert status == 0 and out.startswith("saved")
    assert stored == [list(live.bench.controller.parameters.value)]


def test_a_value_that_reads_back_differently_is_reported(live, comanip, monkeypatch):
    """A value that reads back differently is reported. In this test the value differs as if another client had
    overwritten it."""
    monkeypatch.setattr(OperatorClient, "read", lambda self, name: 0.75)
    require_refused(comanip("param", "set", "motion_scale", 0.5, *BUS), "accepted as 0.5", "0.75")


def test_lost_requests_are_sent_again(live, comanip):
    live.deaf = 3
    assert comanip("task", "select", "pour", *BUS)[0] == 0
    assert len(live.received) >= 4
    sequences = {DBC.decode_message(m.arbitration_id, bytes(m.data))["sequence"] for m in live.received}
    assert len(sequences) == 1, "all frames are the same request"
    assert len({m.data[2] for m in live.received}) == len(live.received), "each frame has a new counter"


def test_no_answer_is_an_error_with_a_deadline(live, comanip):
    live.mute = True
    require_refused(comanip("task", "stop", *BUS), "OperatorCommand", "no CommandAck", "5 attempts")
    wait_until(lambda: len(live.received) == 5, "five requests")


class FloodedBus:
    """A bus on which another frame is always waiting, as when frames arrive faster than they are read. Each takes 1 ms
    of `now_s`. The acknowledgement is read `answered_after_s` after the request."""

    profile = Profile.FD

    def __init__(self, answered_after_s: float = np.inf):
        self.now_s, self.requests, self._answered_after_s = 0.0, 0, answered_after_s

    def send(self, name: str, signals: dict) -> None:
        self.requests += 1
        answer = {"command": signals["command"], "sequence": signals["sequence"], "result": "accepted"}
        self._answer, self._answer_s = protected("CommandAck", answer, 0), self.now_s + self._answered_after_s

    def receive_until(self, deadline_s: float) -> Frame:
        self.now_s += 0.001
        name, data = ("CommandAck", self._answer) if self.now_s > self._answer_s else ("TickTrace", bytes(64))
        return Frame(0, DBC.get_message_by_name(name).frame_id, data)


def test_a_flooded_bus_is_read_for_at_most_twice_the_deadline(monkeypatch):
    silent, late = FloodedBus(), FloodedBus(answered_after_s=0.15)
    monkeypatch.setattr("comanip.bus.operator_client.time.monotonic", lambda: silent.now_s)
    with pytest.raises(ToolError, match="no CommandAck in 3 attempts of 100 ms"):
        OperatorClient(silent, attempts=3, answer_s=0.1).command("stop")
    assert silent.requests == 3 and silent.now_s == pytest.approx(3 * 0.2, abs=0.01)
    monkeypatch.setattr("comanip.bus.operator_client.time.monotonic", lambda: late.now_s)
    OperatorClient(late, attempts=3, answer_s=0.1).command("stop")
    assert late.requests == 1, "the answer arrived after the deadline, but was waiting"


def test_no_bus_is_one_clear_line():
    require_refusal(call("task", "stop", "-i", "nonsense"), "nonsense", "doctor")
    require_refusal(call("param", "get", "trace", "-i", "socketcand", "--port", "1"), "socketcand vcan0", "doctor")
