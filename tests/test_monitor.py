"""`comanip monitor`, `doctor` and `sim`: their output agrees with numpy and with the bit-exact frame lengths of a
log."""

from __future__ import annotations

import re
import subprocess
import threading

import bus_log
import numpy as np
import pytest
from bus_log import DBC
from can_fd_bits import frame_duration_ns
from comanip.bus import logs
from comanip.bus.frame import Frame
from comanip.bus.state import BusState
from comanip_command import COMANIP, call, call_here, require_refusal
from live_firmware import CHANNEL, firmware
from simulation import SHORT, SIMULATOR, shared


@pytest.fixture(scope="module")
def short():
    return shared(*SHORT).require_pass()


@pytest.fixture(scope="module")
def frames(short) -> list[Frame]:
    return list(logs.read(short.log))


@pytest.fixture(scope="module")
def state(frames) -> BusState:
    result = BusState()
    for frame in frames:
        result.feed(frame)
    return result


# ---- the figures


def test_counts_rates_and_signals(short, state, frames):
    decoded = bus_log.read(short.log)
    now_us = frames[-1].t_us
    for name, expected in decoded.items():
        row = state.of(name)
        assert (row.count, row.refused) == (len(expected), 0)
        t_us = np.round(1e6 * expected.t_s)
        assert row.rate_hz(now_us) == np.count_nonzero(t_us > now_us - 10**6)
    assert state.rate_hz() == sum(frame.t_us > now_us - 10**6 for frame in frames)
    last = [frame for frame in frames if frame.name == "FirmwareStatus"][-1]
    assert state.signals("FirmwareStatus") == DBC.decode_message(last.frame_id, last.data)


def test_load_is_a_tight_upper_bound(state, frames):
    now_us = frames[-1].t_us
    exact = sum(frame_duration_ns(f.frame_id, f.data) for f in frames if f.t_us > now_us - 10**6) / 1e7
    assert exact <= state.load_percent() <= 1.15 * exact


def test_a_silent_bus_drops_to_zero(frames):
    state = BusState()
    for frame in frames[:5000]:
        state.feed(frame)
    later_us = state.now_us + 2_000_000
    assert (state.rate_hz(later_us), state.load_percent(later_us)) == (0, 0)


def test_errors_are_counted(frames):
    state = BusState()
    broken = next(frame for frame in frames if frame.name == "JointCmd")
    state.feed(broken._replace(data=broken.data[:-1] + b"\xff"))
    state.feed(Frame(1, 4, bytes(8), fd=False, error=True))
    state.feed(Frame(2, 0x18DAF110, bytes(8), fd=False, brs=False, extended=True))
    assert (state.error_frames, state.of("JointCmd").refused, state.frames) == (1, 1, 2)


# ---- the table


def row(text: str, name: str) -> list[str]:
    return next(line.split() for line in text.splitlines() if name in line)


def test_a_log_as_a_table_at_its_pace(tmp_path, frames):
    (tmp_path / "bus.log").write_text("".join(logs.candump_line(f) + "\n" for f in frames if f.t_us < 1_500_000))
    import time

    began_s = time.monotonic()
    done = call(
        "monitor", "--once", "--log", tmp_path / "bus.log", environment={"COLUMNS": "200", "PATH": "/usr/bin:/bin"}
    )
    assert done.returncode == 0, done.stderr
    assert time.monotonic() - began_s >= 1.4
    assert "cooperating (operator_start), task teleop" in done.stdout
    assert "hand " in done.stdout and "drives answer" in done.stdout
    assert float(re.search(r"bus load at most (\S+) %", done.stdout)[1]) < 66
    joint_command = row(done.stdout, "JointCmd")
    assert joint_command[:3] == ["050", "JointCmd", "Firmware"] and "mode_0" in joint_command
    assert 1490 <= int(joint_command[3]) <= 1500 and int(joint_command[4]) <= 1001


def test_a_live_bus(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "160")
    with firmware() as live:
        status, out, err = call_here(
            monkeypatch, capsys, "monitor", "--once", "--duration", 1, "-i", "virtual", "-c", CHANNEL
        )
        assert status == 0, err
        assert not live.received, "the monitor sends nothing"
    assert "ready (inputs_ready)" in out
    assert "TickTrace" in out and " ok " in out and " wrong" not in out


def test_a_bus_without_firmware(monkeypatch, capsys):
    status, out, _ = call_here(monkeypatch, capsys, "monitor", "--duration", "0.3", "-i", "virtual", "-c", "nobody")
    assert status == 0
    assert "the firmware does not run on this bus" in out


def test_monitor_needs_an_end_for_one_table():
    require_refusal(call("monitor", "--once"), "--once", "--duration")
    require_refusal(call("monitor", "--log", "missing.log"), "missing.log", "No such file")


# ---- doctor, sim, help


def test_doctor_lists_what_is_installed_and_how_to_install_the_rest(tmp_path):
    done = call("doctor", environment={"PATH": str(tmp_path), "COLUMNS": "200", "COMANIP_HUB_DIR": str(tmp_path)})
    assert done.returncode == 0, done.stderr
    rows = {line[6:28].strip(): line for line in done.stdout.splitlines()[1:]}
    assert rows["python-can"].startswith("ok")
    assert rows["compiled core"].startswith("ok") and rows["simulator"].startswith("ok")
    assert rows["gcc"].startswith("none") and "apt-get install gcc" in rows["gcc"]
    assert rows["candump"].startswith("none") and "can-utils" in rows["candump"]
    assert rows["hub"].startswith("none") and "make hub" in rows["hub"]


def test_doctor_sees_a_hub(tmp_path):
    import socket

    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as hub:
        hub.bind(str(tmp_path / "vcan7"))
        done = call("doctor", environment={"PATH": "/usr/bin:/bin", "COLUMNS": "200", "COMANIP_HUB_DIR": str(tmp_path)})
    assert re.search(r"^ok +hub +.*vcan7", done.stdout, re.MULTILINE)


def test_sim_is_the_simulator(tmp_path):
    options = ["--scenario", "teleop", "--duration", "2.5", "--quiet", "--seed", "4"]
    ours = call("sim", *options, "--out", tmp_path / "ours")
    plain = subprocess.run(
        [SIMULATOR, *options, "--out", tmp_path / "plain"], capture_output=True, text=True, check=False
    )
    assert (ours.returncode, ours.stdout) == (plain.returncode, plain.stdout)
    assert (tmp_path / "ours" / "bus.log").read_bytes() == (tmp_path / "plain" / "bus.log").read_bytes()
    assert (
        call("sim", "--", "--help").stdout
        == subprocess.run([SIMULATOR, "--help"], capture_output=True, text=True, check=True).stdout
    )
    assert call("sim", "--scenario", "juggle").returncode == 2


COMMANDS = ("sim", "replay", "monitor", "decode", "convert", "tracker", "calibrate", "doctor", "task", "param")


def test_every_command_has_help_with_examples():
    overview = call("--help").stdout
    for command in COMMANDS:
        assert re.search(rf"^│ {command} ", overview, re.MULTILINE)
    found: list[str] = []

    def ask(command: str) -> None:
        done = call(command, "--help")
        assert done.returncode == 0 and done.stderr == ""
        assert "Examples" in done.stdout and f"comanip {command}" in done.stdout, command
        found.append(command)

    threads = [threading.Thread(target=ask, args=(command,)) for command in COMMANDS]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(found) == sorted(COMMANDS)


def test_the_shell_completes_commands():
    environment = {
        "_COMANIP_COMPLETE": "complete_bash",
        "COMP_WORDS": "comanip re",
        "COMP_CWORD": "1",
        "PATH": "/usr/bin:/bin",
    }
    done = subprocess.run([COMANIP], capture_output=True, text=True, check=False, env=environment)
    assert done.stdout.split() == ["replay"]


def test_wrong_use_is_status_2():
    for arguments in (
        ["juggle"],
        ["replay"],
        ["task", "select"],
        ["param", "set", "motion_scale", "much"],
        ["monitor", "--port", "0"],
    ):
        assert call(*arguments).returncode == 2, arguments
