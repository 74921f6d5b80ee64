"""Checks `comanip` as a user runs it. Firmware and plant are two processes on a hub. The tests watch and operate them
through socketcand and, with the shim, through SocketCAN. The log recorded meanwhile replays without a difference."""

from __future__ import annotations

import re
import signal
import subprocess

import pytest
from comanip_command import COMANIP, WRONG_USE
from hub import PATIENCE_S, WITH_CAN, Hub, running, tool, wait_until
from live import FIRMWARE, PLANT, SLOWER
from simulation import REPOSITORY

STATUS = r"^(idle|ready|cooperating|hold|fault) \(\w+\), task \w+"
SCENE = REPOSITORY / "tests" / "scenarios" / "teleop_moves.yaml"


def comanip(hub: Hub, through: str, *arguments: object) -> subprocess.CompletedProcess:
    bus = {"socketcand": ["-i", "socketcand", "--port", hub.port], "shim": []}[through]
    program = [WITH_CAN, COMANIP] if through == "shim" else [COMANIP]
    command = [str(part) for part in (*program, *arguments, *bus)]
    return subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE_S,
        env={**hub.environment, "COLUMNS": "200"},
    )


@pytest.fixture(scope="module", params=["fd", "classic"])
def session(tmp_path_factory, request):
    """Runs firmware and plant on a hub. Yields the hub, the plant, the firmware and the folder of the plant's log. The
    plant's own operator starts the task only at 500 s, when the tests are over. On a busy machine the firmware might
    refuse an earlier start, and the refusal would end the run."""
    out = tmp_path_factory.mktemp("plant")
    scene = out / "scene.yaml"
    scene.write_text(SCENE.read_text().replace("{do: start, at_s: 0.5}", "{do: start, at_s: 500}"))
    with running("--socketcand", "0") as hub:
        with tool(
            hub, PLANT, "--can", hub.bus, "--slow", SLOWER, "--profile", request.param, "--scenario", scene,
            "--duration", 600, "--out", out,
        ) as plant:  # fmt: skip
            wait_until(lambda: "waits for the firmware" in plant.text(), "the plant")
            with tool(hub, FIRMWARE, "--can", hub.bus, "--slow", SLOWER, "--profile", request.param) as firmware:
                yield hub, plant, firmware, out


def accepted(hub: Hub, through: str, *arguments: object) -> bool:
    """Returns whether the command was accepted. A refusal is no error, since a busy machine may pause a process."""
    return comanip(hub, through, *arguments).returncode == 0


def stopped(hub: Hub, through: str) -> bool:
    """Stops the cooperation, or acknowledges a fault, which the pause of a process causes."""
    return accepted(hub, through, "task", "stop") or accepted(hub, through, "task", "acknowledge")


@pytest.mark.parametrize("through", ["socketcand", "shim"])
def test_watch_and_operate(session, through):
    hub, plant, firmware, _ = session

    def monitored() -> object:
        """Monitors for one second. Returns a true value if the monitor shows the firmware's status and the last drive,
        which may be missing just after the firmware has started."""
        plant.require_running()
        firmware.require_running()
        shown = comanip(hub, through, "monitor", "--once", "--duration", 1)
        assert shown.returncode == 0, shown.stderr
        assert " wrong" not in shown.stdout
        return "JointState3" in shown.stdout and re.search(STATUS, shown.stdout)

    wait_until(monitored, "the firmware's status and the drives' states in the monitor")
    # Repeat both commands, because either may be refused; see accepted().
    write = ("param", "set", "motion_scale", "0.5")
    wait_until(lambda: stopped(hub, through) and accepted(hub, through, *write), "a write at rest")
    read = comanip(hub, through, "param", "get", "motion_scale")
    assert (read.returncode, read.stdout) == (0, "0.5\n"), read.stderr
    refused = comanip(hub, through, "param", "save")
    assert refused.returncode == WRONG_USE and "not_supported" in refused.stderr
    wait_until(lambda: accepted(hub, through, "task", "select", "mirror"), "select")
    wait_until(lambda: stopped(hub, through) and accepted(hub, through, "task", "start"), "start")


def test_the_recording_replays(session):
    """The log replays without a difference. This test must run last, because it stops firmware and plant."""
    _, plant, firmware, out = session
    firmware.process.send_signal(signal.SIGINT)
    firmware.process.wait(PATIENCE_S)
    plant.process.send_signal(signal.SIGINT)
    plant.process.wait(PATIENCE_S)
    replayed = subprocess.run([COMANIP, "replay", out / "bus.log"], capture_output=True, text=True, check=False)
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr
    decoded = subprocess.run(
        [COMANIP, "decode", out / "bus.log", "--only", "CommandAck"], capture_output=True, text=True, check=True
    )
    assert "command select" in decoded.stdout and "command start" in decoded.stdout
