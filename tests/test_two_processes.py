"""Firmware and plant, as two processes on one bus, cooperate as they do in the simulator. After they lose contact, they
find each other again, but the arm moves only after an explicit re-arm."""

from __future__ import annotations

import json
import signal
import socket
import subprocess

import pytest
from bus_log import DBC
from comanip_command import call
from live import (
    ATTEMPTS,
    CAN_FRAME,
    CANFD_FRAME,
    FIRMWARE,
    INTERFACE,
    PLANT,
    REPOSITORY,
    SLOW,
    Bus,
    has_kernel_can,
    is_authentic,
)
from simulation import PATIENCE_S
from test_bus_log import logged_frames

PLAIN = REPOSITORY / "tests" / "scenarios" / "teleop_moves.yaml"
JOINTS = 4
PAUSE_S = 0.050
NAMES_A_LOSS = {"drive_silent", "drive_error"}


@pytest.fixture(scope="module")
def waving(tmp_path_factory) -> str:
    """Writes a scenario in which the hand moves all the time. The scenario's operator sends its commands so late that
    the test can take the operator's place."""
    text = PLAIN.read_text()
    to_and_fro = [f"      - {{do: move, to_m: [{0.03 * (i % 2)}, 0, 0], duration_s: 0.5}}\n" for i in range(38)]
    before, rest = text.split("    program:\n")
    operator = rest[rest.index("operator:") : rest.index("tracking:")].replace("at_s: 0.5", "at_s: 100")
    path = tmp_path_factory.mktemp("scene") / "waving.yaml"
    path.write_text(
        before + "    program:\n      - {do: rest, at_s: 0.6, duration_s: 0.1}\n" + "".join(to_and_fro) + operator
    )
    return str(path)


@pytest.fixture
def bus(tmp_path):
    with Bus(tmp_path) as bus_:
        yield bus_


@pytest.fixture(params=["fd", "classic"])
def either_bus(tmp_path, request):
    with Bus(tmp_path, profile=request.param) as bus_:
        yield bus_


def begin(bus: Bus, scenario: str, *options: object) -> tuple[subprocess.Popen, subprocess.Popen]:
    """Starts the plant before the firmware, so that the plant's log begins with the firmware's boot."""
    plant = bus.plant("--scenario", scenario, *options)
    bus.wait(lambda: "waits for the firmware" in bus.output("plant.out") or plant.poll() is not None, "the plant")
    return plant, bus.firmware()


def cooperate(bus: Bus) -> None:
    """Starts the arm and waits until it cooperates and moves. Starts it again if it leaves the mode cooperating because
    the machine was busy."""
    bus.wait_mode("ready", "fault", start=len(bus.frames))
    while True:
        rearm(bus)
        start = len(bus.frames)
        bus.wait(lambda start=start: moves(bus, start) or bus.status()[0] != "cooperating", "the arm moves")
        if bus.status()[0] == "cooperating":
            return


def moves(bus: Bus, start: int) -> bool:
    return any(abs(c[f"velocity_{i}_radps"]) > 0.05 for c in bus.commands(start, JOINTS)[-1:] for i in range(JOINTS))


def rearm(bus: Bus) -> None:
    """Re-arms as a user does: stop, acknowledge the fault, if any, then start."""
    result = ""
    while result != "accepted":
        bus.wait(
            lambda: bus.command("stop") == "accepted" or bus.command("acknowledge") == "accepted",
            "standstill without the fault's cause",
        )
        bus.wait_mode("ready", start=len(bus.frames))
        result = bus.command("start")
    bus.wait_mode("cooperating", "hold", "fault", start=len(bus.frames))


def require_standstill(bus: Bus, start: int) -> None:
    """Checks that, from frame `start` on, the brakes are engaged and no joint turns by more than the encoder noise."""
    for joint in range(JOINTS):
        states = [frame.decode() for frame in bus.since(start, f"JointState{joint}")]
        assert states
        assert {str(state["mode"]) for state in states} == {"brake"}
        positions = [state["position_rad"] for state in states]
        assert max(positions) - min(positions) < 1e-3


# ---- together


@pytest.fixture(scope="module", params=["fd", "classic"])
def together(tmp_path_factory, request):
    """Returns a complete run: its folder, the frames that the tap recorded, and the output of both processes."""
    for attempt in range(ATTEMPTS):
        folder = tmp_path_factory.mktemp("together")
        with Bus(folder, SLOW << attempt, request.param) as bus_:
            if run_to_end(bus_, 4) == 0:
                break
    return folder, bus_.frames, bus_.output("firmware.out"), bus_.output("plant.out")


def run_to_end(bus: Bus, duration_s: float) -> int:
    """Runs the plant on a bus that the firmware joins and leaves. Checks that the firmware's exit status is 0, and
    returns that of the plant."""
    plant, firmware = begin(bus, str(PLAIN), "--duration", duration_s)
    bus.wait(lambda: plant.poll() is not None, "the plant's end")
    firmware.send_signal(signal.SIGTERM)
    assert firmware.wait() == 0, bus.output("firmware.err")
    return plant.returncode


def test_the_arm_follows_as_in_the_simulator(together):
    folder, _, _, _ = together
    summary = json.loads((folder / "plant" / "summary.json").read_text())
    assert summary["result"] == "pass", summary["reason"]
    assert summary["sim_s"] == 4
    assert summary["real_time"]["slow"] in [SLOW << attempt for attempt in range(ATTEMPTS)]
    modes = [change["mode"] for change in summary["modes"]]
    after = modes[modes.index("cooperating") + 1 :]
    # a busy machine may make the drives appear silent for a moment, which logs a new reason but no new mode
    assert set(after) == {"ready"}
    assert "forward" in {check["name"] for check in summary["checks"]}, "the hand's displacement is judged"


def test_each_process_names_its_bus(together):
    _, _, firmware, plant = together
    kind = "the kernel's interface" if has_kernel_can() else "the hub "
    assert f"comanip-firmware: {INTERFACE} is {kind}" in firmware
    assert f"comanip-plant: {INTERFACE} is {kind}" in plant
    stamps = (
        "the kernel's, since the CAN controller gives none"
        if has_kernel_can()
        else "estimated from the ticks, since a hub gives none"
    )
    assert (
        firmware.count(f"comanip-firmware: times of reception: {stamps}\n") == firmware.count("times of reception") == 1
    )
    for output in (firmware, plant):
        assert ("real-time priority" in output) != ("not real-time" in output)


def test_the_plants_log_matches_the_bus(together):
    """If the kernel returns the plant's own frames to the plant, the plant's log has the order of the bus. Otherwise
    only the frames of each id are in this order."""
    folder, seen, _, _ = together
    logged = [(frame.frame_id, frame.data) for frame in logged_frames(folder / "plant" / "bus.log")]
    tapped = [(frame.frame_id, frame.data) for frame in seen]
    first = tapped.index(logged[0])
    for frame_id in {frame_id for frame_id, _ in logged}:
        mine = [data for i, data in logged if i == frame_id]
        tap = [data for i, data in tapped[first:] if i == frame_id]
        assert tap[: len(mine)] == mine, DBC.get_message_by_frame_id(frame_id).name
    if has_kernel_can():
        assert tapped[first : first + len(logged)] == logged


def test_all_frames_are_decodable_and_protected(together):
    _, seen, _, _ = together
    names = set()
    last: dict[int, int] = {}
    for frame in seen:
        message = DBC.get_message_by_frame_id(frame.frame_id)
        names.add(message.name)
        assert frame.decode().keys() == {signal_.name for signal_ in message.signals}
        assert is_authentic(frame) is not False, message.name
        if is_authentic(frame):
            counter, counters = frame.decode()["e2e_counter"], 1 << message.get_signal_by_name("e2e_counter").length
            assert counter == (last.get(frame.frame_id, counter - 1) + 1) % counters, message.name
            last[frame.frame_id] = counter
    assert len(names) > 12 and len({name.startswith("Classic") for name in names - {"FirmwareHeartbeat"}}) == 1


def test_the_plants_log_replays_byte_for_byte(together):
    folder, _, _, _ = together
    replayed = call("replay", folder / "plant" / "bus.log")
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr


# ---- losing contact


def test_firmware_paused(either_bus, waving):
    """When the firmware is paused, the drives brake on their own. When the firmware resumes, it reports the cause and
    moves nothing."""
    bus = either_bus
    _, firmware = begin(bus, waving, "--duration", 110)
    cooperate(bus)
    start = len(bus.frames)
    firmware.send_signal(signal.SIGSTOP)
    bus.wait(lambda: is_timed_out(bus, start), "the drives notice")
    bus.wait(lambda: len(bus.since(start, "JointState0")) > pause_frames(bus), "the pause")
    require_brake_after_timeout(bus, start)
    paused = len(bus.frames)
    firmware.send_signal(signal.SIGCONT)
    bus.wait_mode("fault", start=paused)
    assert bus.status()[1] in NAMES_A_LOSS
    require_latched_fault(bus)


def test_firmware_killed_and_started_again(either_bus, waving):
    bus = either_bus
    _, firmware = begin(bus, waving, "--duration", 110)
    cooperate(bus)
    start = len(bus.frames)
    firmware.kill()
    firmware.wait()
    bus.wait(lambda: is_timed_out(bus, start), "the drives notice")
    require_brake_after_timeout(bus, start)
    stopped = len(bus.frames)
    bus.wait(lambda: len(bus.since(stopped, "JointState0")) > 50, "the drives keep reporting")
    require_standstill(bus, stopped + len(bus.frames[stopped:]) // 2)
    again = len(bus.frames)
    bus.firmware("firmware_again")
    bus.wait_mode("ready", start=again)
    assert bus.since(again, "FirmwareIdentity"), "the firmware announces itself"
    assert {mode for mode, _ in bus.statuses_for(0.1)} == {"ready"}, "the cooperation does not start by itself"
    cooperate(bus)


def test_plant_paused(either_bus, waving):
    bus = either_bus
    plant, _ = begin(bus, waving, "--duration", 110)
    cooperate(bus)
    start = len(bus.frames)
    plant.send_signal(signal.SIGSTOP)
    require_stop_of_the_commands(bus, start)
    bus.wait(lambda: len(bus.commands(start, JOINTS)) > pause_frames(bus), "the pause")
    plant.send_signal(signal.SIGCONT)
    require_latched_fault(bus)


def test_plant_killed_and_started_again(either_bus, waving):
    bus = either_bus
    plant, _ = begin(bus, waving, "--duration", 110)
    cooperate(bus)
    start = len(bus.frames)
    plant.kill()
    plant.wait()
    require_stop_of_the_commands(bus, start)
    # the fault remains; after a second without a tracker, the firmware accepts the clock of a new one
    assert {mode for mode, _ in bus.statuses_for(1.2)} == {"fault"}
    bus.plant("--scenario", waving, "--duration", 110, name="plant_again")
    bus.wait(lambda: is_answered(bus), "the drives answer again")
    assert bus.status()[0] == "fault", "the fault stays latched"
    cooperate(bus)


def require_latched_fault(bus: Bus) -> None:
    """Checks that the fault stays latched, that the arm rests, and that the operator can start again."""
    assert set(bus.statuses_for(0.1)) == {("fault", bus.status()[1])}
    start = len(bus.frames)
    bus.statuses_for(0.05)
    require_standstill(bus, start)
    cooperate(bus)


def pause_frames(bus: Bus) -> float:
    """Returns how many times a once-per-tick frame is due during the pause."""
    return 1000 * PAUSE_S / bus.message("JointState0").cycle_time


def is_timed_out(bus: Bus, start: int) -> bool:
    return any(str(frame.decode()["error"]) == "command_timeout" for frame in bus.since(start, "JointState0"))


def is_answered(bus: Bus) -> bool:
    start = max(0, len(bus.frames) - 30)
    return bool(bus.since(start, "JointState0")) and bool(bus.since(start, "HandPose"))


def require_brake_after_timeout(bus: Bus, start: int) -> None:
    """Checks that each drive engages its brake and reports that commands are missing."""
    for joint in range(JOINTS):
        bus.wait(lambda joint=joint: len(bus.since(start, f"JointState{joint}")) > 15, "JointState")
        states = [frame.decode() for frame in bus.since(start, f"JointState{joint}")]
        # The first JointState after a timeout still contains the mode before it. A busy machine may cause a timeout of
        # its own before the pause.
        late = [str(state["error"]) == "command_timeout" for state in states]
        modes = {str(states[i]["mode"]) for i in range(1, len(states)) if late[i - 1] and late[i]}
        assert modes == {"brake"}


def require_stop_of_the_commands(bus: Bus, start: int) -> None:
    """Checks that the firmware reports the cause, and that its commands ramp down and then engage the brakes."""
    bus.wait_mode("fault", start=start)
    assert bus.status()[1] in NAMES_A_LOSS
    faulted = next(
        i
        for i, f in enumerate(bus.frames[start:], start)
        if f.name == bus.message("FirmwareStatus").name and str(f.decode()["mode"]) == "fault"
    )
    bus.wait(
        lambda: any(str(command["mode_0"]) == "brake" for command in bus.commands(faulted, JOINTS)[-1:]),
        "the brake command",
    )
    speed = [
        max(abs(command[f"velocity_{i}_radps"]) for i in range(JOINTS)) for command in bus.commands(faulted, JOINTS)
    ]
    assert all(after <= before + 1e-3 for before, after in zip(speed, speed[1:], strict=False)), "the speed never rises"
    assert speed[-1] == 0


# ---- the platform itself


@pytest.mark.skipif(has_kernel_can(), reason="the kernel's bus has no hub")
def test_a_hub_that_ends_and_returns(bus, tmp_path):
    process = bus.firmware()
    bus.wait_mode("idle")
    bus.hub.kill()
    bus.hub.wait()
    bus.wait(lambda: f"comanip-firmware: {INTERFACE}: lost: " in bus.output("firmware.err"), "the report")
    with Bus(tmp_path) as again:
        again.wait(lambda: again.since(0, "JointCmd"), "commands again")
        assert again.command("select") == "accepted"
        process.send_signal(signal.SIGTERM)
        assert process.wait() == 0
    output = bus.output("firmware.err")
    assert output.count("lost: ") == 1
    assert f"comanip-firmware: {INTERFACE}: back\n" in output
    assert f"comanip-firmware: {INTERFACE}: 1 times without the bus\n" in output


@pytest.mark.skipif(has_kernel_can(), reason="the kernel does not let such packets through")
def test_malformed_packets_are_ignored(bus):
    process = bus.firmware()
    bus.wait_mode("idle")
    command_id = DBC.get_message_by_name("OperatorCommand").frame_id
    bus.send_packet(CAN_FRAME.pack(command_id, 64, 0, 0, 0, bytes(8)))
    bus.send_packet(CANFD_FRAME.pack(command_id, 255, 0, 0, 0, bytes(64)))
    assert bus.command("select") == "accepted"
    process.send_signal(signal.SIGTERM)
    assert process.wait() == 0
    assert "foreign" not in bus.output("firmware.err"), "the hub forwards none of them"
    assert bus.output("hub.err"), "the hub reports them"


@pytest.mark.parametrize("program", [FIRMWARE, PLANT])
def test_a_hub_in_a_folder_that_others_may_write_to_is_not_trusted(tmp_path, program):
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as listener:
        listener.bind(str(tmp_path / "theirs"))
        listener.listen()
        tmp_path.chmod(0o777)
        done = subprocess.run(
            [program, "--can", "theirs"],
            capture_output=True,
            text=True,
            check=False,
            timeout=PATIENCE_S,
            env={"COMANIP_HUB_DIR": str(tmp_path)},
        )
    assert done.returncode == 2
    expected = f"{tmp_path}: expected a folder of yours or of root that only its owner may write to\n"
    assert done.stderr == f"{program.name}: {expected}"


def test_watchdog_ends_a_loop_that_hangs(bus, tmp_path):
    """If firmware that hangs in an endless loop is linked to the port, the watchdog ends its process with a message."""
    main = tmp_path / "hanging.c"
    main.write_text(
        '#include "hal/hal.h"\n#include "firmware/main.h"\n'
        "void firmware_main(void) {\n    hal_init();\n    uint32_t now_us;\n"
        "    for (int i = 0; i < 20 && hal_wait_tick(&now_us); i++) {\n        hal_watchdog_feed();\n    }\n"
        "    for (volatile int forever = 1; forever != 0;) {\n    }\n}\n"
    )
    program = tmp_path / "hanging"
    names = (
        "can_classic",
        "can_protocol",
        "can_transport",
        "rotation_code",
        "e2e",
        "dual_quaternion",
        "pose",
        "trigonometry",
    )
    sources = [
        *(REPOSITORY / "hal" / "linux").glob("*.c"),
        *(file for file in sorted((REPOSITORY / "firmware").rglob("*.c")) if file.stem in names),
        REPOSITORY / "build" / "generated" / "comanip_dbc.c",
        main,
    ]
    subprocess.run(
        ["gcc", "-std=c11", "-O1", "-D_DEFAULT_SOURCE", "-pthread", f"-I{REPOSITORY}",
         f"-I{REPOSITORY}/build/generated",
         *map(str, sources), "-lm", "-o", str(program)], check=True,
    )  # fmt: skip
    process = bus.firmware("hanging", program)
    assert process.wait(timeout=PATIENCE_S) == 1
    assert bus.output("hanging.err") == "comanip-firmware: panic: watchdog: not fed by the firmware for 10 ticks\n"


@pytest.mark.parametrize("program", [FIRMWARE, PLANT])
@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ([], "expected --can NAME"),
        (["--can"], "--can '': expected the name"),
        (["--can", "nobus7"], "nobus7: no such CAN interface in the kernel, and no hub at /nowhere/nobus7"),
        (["--can", "a/b"], "'a/b': expected the name of a CAN interface"),
        (["--can", "a_name_that_is_too_long"], "expected the name of a CAN interface"),
        (["--can", "vcan0", "--slow", "0"], "--slow '0': expected a whole number from 1 to 1000"),
        (["--can", "vcan0", "--slow=x"], "--slow 'x': expected a whole number from 1 to 1000"),
        (["--can", "vcan0", "--sloppy"], "'--sloppy': no such option"),
        (["--can", "vcan0", "x\x1b[2Jy"], "x?[2Jy"),
    ],
)
def test_wrong_use_gives_one_clear_line(program, arguments, expected, tmp_path):
    done = subprocess.run(
        [program, *arguments],
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE_S,
        cwd=tmp_path,
        env={"COMANIP_HUB_DIR": "/nowhere"},
    )
    assert done.returncode == 2
    assert expected in done.stderr
    assert done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == [], "nothing must be written"


@pytest.mark.parametrize("program", [FIRMWARE, PLANT])
def test_help(program):
    done = subprocess.run([program, "--help"], capture_output=True, text=True, check=True)
    assert "--can NAME" in done.stdout
    assert "--slow N" in done.stdout
    assert done.stderr == ""
