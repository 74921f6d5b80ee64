"""Faults of the port are reported in PortStatus frames, by `comanip monitor` and in summary.json. The tests inject them
into the simulator, a bench around the controller, and the Linux process. test_target.py checks the counts in the images
for microcontrollers."""

from __future__ import annotations

import ctypes
import json
import signal
import subprocess

import pytest
from bus_log import DBC
from comanip._core import lib
from comanip.bus import logs
from comanip.bus.frame import decode, protected
from comanip.replay import Replay
from comanip_command import call
from controller_bench import Bench
from images import make
from live import CAN_FRAME, SLOWER, Bus, has_kernel_can
from simulation import REPOSITORY, run

PLAIN = REPOSITORY / "tests" / "scenarios" / "teleop_moves.yaml"
UNKNOWN = "unknown"
NOT_MEASURED = "the port does not measure the values that are null"
COUNTS = ("refused_frames", "lost_frames", "error_passive", "bus_off", "missed_ticks", "longest_tick_us")


def statuses(frames) -> list[dict]:
    """Returns the signals of each PortStatus in a log of CAN FD frames. A signal whose value is unknown is the string
    UNKNOWN."""
    return [
        {name: str(value) if str(value) == UNKNOWN else value for name, value in decode(frame).items()}
        for frame in frames
        if frame.name == "PortStatus"
    ]


# ---- the simulator: frames refused and lost


INJECTED = """
#include "hal/hal.h"
#include "sim/bus/bus.h"
bool __real_bus_send(bus_t *self, int node, const can_frame_t *frame, int64_t ready_ns);
bool __wrap_bus_send(bus_t *self, int node, const can_frame_t *frame, int64_t ready_ns) {
    static int traces;
    if (frame->id == 0x060 && ++traces > 700 && traces <= 712) {
        return false; /* as if the queue were full for twelve ticks */
    }
    return __real_bus_send(self, node, frame, ready_ns);
}
bool __real_hal_can_receive(can_frame_t *frame);
bool __wrap_hal_can_receive(can_frame_t *frame) {
    static int asked;
    ++asked;
    return (asked < 40 || asked >= 60) && __real_hal_can_receive(frame); /* receives nothing for twenty ticks */
}
"""


@pytest.fixture(scope="module")
def injected(tmp_path_factory):
    """Runs the simulator with a bus and a receive queue that fail on purpose."""
    folder = tmp_path_factory.mktemp("injected")
    (folder / "injected.c").write_text(INJECTED)
    objects = make("--eval", "objects: ; @echo $(HOST_OBJECTS)", "objects").stdout.split()
    assert len(objects) > 50
    flags = ["-std=c11", f"-I{REPOSITORY}", f"-I{REPOSITORY}/build/generated"]
    link = ["-Wl,--wrap=bus_send,--wrap=hal_can_receive", "-lode", "-lccd", "-lyaml", "-lm", "-o", folder / "simulator"]
    command = ["gcc", *flags, folder / "injected.c", *objects, *link]
    subprocess.run(command, cwd=REPOSITORY, check=True)
    done = subprocess.run(
        [folder / "simulator", "--scenario", PLAIN, "--out", folder / "out", "--duration", "2", "--quiet"],
        capture_output=True,
        check=False,
    )
    assert done.returncode in (0, 1), done.stderr
    return folder / "out"


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    return run(tmp_path_factory.mktemp("plain"), "--scenario", "teleop", "--duration", 3).require_pass()


def summary_of(out) -> dict:
    return json.loads((out / "summary.json").read_text())


def test_frames_that_the_bus_refused_or_that_were_lost_are_in_the_frame(injected):
    reported = statuses(logs.read(injected / "bus.log"))
    assert len(reported) == 20
    refused = [status["refused_frames"] for status in reported]
    assert refused[0] == 0 and refused[-1] == 12 and refused == sorted(refused)
    lost = summary_of(injected)["bus"]["dropped"]  # the bus model itself dropped no frame
    assert reported[-1]["lost_frames"] == lost > 0


def test_the_summary_has_the_last_ones(injected, plain):
    last = statuses(logs.read(injected / "bus.log"))[-1]
    expected = {name: None if last[name] == UNKNOWN else last[name] for name in COUNTS}
    assert summary_of(injected)["port"] == {"can_state": "unknown"} | expected | {"not_measured": NOT_MEASURED}
    unknown = {"error_passive": None, "bus_off": None, "longest_tick_us": None}
    counted = {"refused_frames": 0, "lost_frames": 0, "missed_ticks": 0}
    assert plain.summary["port"] == {"can_state": "unknown", "not_measured": NOT_MEASURED} | unknown | counted


def test_the_monitor_says_so_in_plain_words_and_nothing_where_nothing_is_wrong(injected, plain):
    shown = call("monitor", "--log", injected / "bus.log", "--once").stdout
    lost = summary_of(injected)["port"]["lost_frames"]
    assert f"port, since boot: 12 frames not sent, {lost} received frames lost\n" in shown
    assert "since boot" not in call("monitor", "--log", plain.log, "--once").stdout


# ---- the controller


def test_what_the_port_says_is_sent_every_100_ms_after_the_heartbeat():
    bench = Bench()
    port = {"can_state": lib.PORT_CAN_ERROR_PASSIVE} | {name: 1000 + i for i, name in enumerate(COUNTS)}
    port["bus_off"] = 65535
    for name, value in port.items():
        setattr(bench.inbox.port, name, value)
    ids = [DBC.get_message_by_name(name).frame_id for name in ("PortStatus", "FirmwareHeartbeat")]
    sent = {frame_id: [] for frame_id in ids}
    for tick in range(1000):
        bench.tick()
        for frame_id, data in bench.sent:
            if frame_id in sent:
                sent[frame_id].append((tick, data))
    assert [tick for tick, _ in sent[ids[0]]] == list(range(1, 1000, 100))
    assert [tick for tick, _ in sent[ids[1]]] == list(range(0, 1000, 100))
    reported = DBC.decode_message(ids[0], sent[ids[0]][-1][1])
    assert str(reported["can_state"]) == "error_passive" and str(reported["bus_off"]) == UNKNOWN
    assert all(reported[name] == port[name] for name in COUNTS if name != "bus_off")


def test_counts_saturate_below_unknown(tmp_path):
    source = tmp_path / "count.c"
    source.write_text(
        '#include "firmware/protocol/port_status.h"\nuint16_t count(uint64_t n) { return port_count(n); }\n'
    )
    command = [
        "gcc",
        "-shared",
        "-fPIC",
        f"-I{REPOSITORY}",
        f"-I{REPOSITORY}/build/generated",
        source,
        "-o",
        tmp_path / "count.so",
    ]
    subprocess.run(command, check=True)
    count = ctypes.CDLL(tmp_path / "count.so").count
    count.argtypes, count.restype = [ctypes.c_uint64], ctypes.c_uint16
    assert [count(n) for n in (0, 1, 65533, 65534, 65535, 65536, 2**32, 2**63)] == [0, 1, 65533, *[65534] * 5]


# ---- a replay leaves PortStatus out, and says so


def test_a_replay_names_what_it_leaves_out(plain):
    done = call("replay", plain.log)
    assert done.returncode == 0
    assert "not compared, because the log does not determine it: PortStatus" in done.stdout


def replaced(frames, change):
    """Replaces the data of the tenth PortStatus."""
    place = [i for i, frame in enumerate(frames) if frame.name == "PortStatus"][9]
    frames = list(frames)
    frames[place] = frames[place]._replace(data=change(frames[place]))
    return place, frames


def replayed(frames):
    replay = Replay(frames)
    for _ in replay.run():
        pass
    return replay.report()


def test_another_port_status_is_no_difference_but_a_damaged_one_is(plain):
    frames = list(logs.read(plain.log))
    _, others = replaced(frames, lambda f: protected("PortStatus", decode(f) | {"missed_ticks": 7}, f.counter))
    assert replayed(others).difference is None
    place, damaged = replaced(frames, lambda f: f.data[:-1] + bytes([f.data[-1] ^ 1]))
    assert replayed(damaged).difference.place == place
    without = [frame for frame in frames if frame.name != "PortStatus"]
    assert replayed(without).difference is None and replayed(without).left_out == ()


# ---- the Linux process


ERROR_FLAG = 0x20000000  # linux/can.h, linux/can/error.h
ERROR_CONTROLLER, ERROR_BUS_OFF, ERROR_RESTARTED = 0x004, 0x040, 0x100
RX_OVERFLOW, TX_PASSIVE, ACTIVE = 0x01, 0x20, 0x40


@pytest.fixture
def alone(tmp_path):
    """Runs the firmware without a plant, on a hub."""
    if has_kernel_can():
        pytest.skip("the kernel's bus has no hub to be stopped")
    with Bus(tmp_path, SLOWER) as bus:
        process = bus.firmware()
        bus.wait_mode("idle")
        yield bus, process


def wait_status(bus: Bus, condition, what: str) -> dict:
    """Waits for the first PortStatus from now on that meets the condition, and returns it."""
    start, found = len(bus.frames), []

    def is_there() -> bool:
        reported = [frame.decode() for frame in bus.since(start, "PortStatus")]
        found[:] = [status for status in reported if condition(status)]
        return bool(found)

    bus.wait(is_there, what)
    return found[0]


def send_error(bus: Bus, classes: int, controller: int = 0) -> None:
    bus.send_packet(CAN_FRAME.pack(ERROR_FLAG | classes, 8, 0, 0, 0, bytes([0, controller]) + bytes(6)))


def test_error_states_of_the_controller(alone):
    bus, _ = alone
    status = wait_status(bus, lambda s: True, "PortStatus")
    assert (str(status["can_state"]), str(status["bus_off"])) == (UNKNOWN, UNKNOWN)  # a hub has no CAN controller
    for classes, controller, state in (
        (ERROR_CONTROLLER, TX_PASSIVE, "error_passive"),
        (ERROR_CONTROLLER, ACTIVE, "error_active"),
        (ERROR_BUS_OFF, 0, "bus_off"),
        (ERROR_RESTARTED, 0, "error_active"),
    ):
        send_error(bus, classes, controller)
        status = wait_status(bus, lambda s, state=state: str(s["can_state"]) == state, state)
    send_error(bus, ERROR_CONTROLLER, RX_OVERFLOW)
    status = wait_status(bus, lambda s: s["lost_frames"] == 1, "a frame lost by the controller")
    assert (status["error_passive"], status["bus_off"]) == (1, 1)


def test_a_full_transmit_queue(alone):
    """The transmit queue fills up while the hub accepts nothing."""
    bus, process = alone
    assert wait_status(bus, lambda s: True, "PortStatus")["refused_frames"] == 0
    bus.hub.send_signal(signal.SIGSTOP)
    try:
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(3)
    finally:
        bus.hub.send_signal(signal.SIGCONT)
    status = wait_status(bus, lambda s: s["refused_frames"] > 0, "frames refused")
    process.send_signal(signal.SIGTERM)
    process.wait()
    at_exit = int(bus.output("firmware.err").split(" frames not sent")[0].split()[-1])
    assert 0 < status["refused_frames"] <= at_exit


def test_a_late_tick(alone):
    bus, process = alone
    before = wait_status(bus, lambda s: True, "PortStatus")
    process.send_signal(signal.SIGSTOP)
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(0.02 * bus.slow)
    process.send_signal(signal.SIGCONT)
    status = wait_status(bus, lambda s: s["missed_ticks"] >= before["missed_ticks"] + 10, "ticks missed")
    # the pause counts as a long tick only if it came while the process was executing a tick, not asleep
    assert 0 < status["longest_tick_us"] != UNKNOWN
