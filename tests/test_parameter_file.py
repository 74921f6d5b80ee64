"""The Linux port stores the firmware's parameters in a file: they are saved, survive a restart and any interruption,
and cause a clear error if they cannot be saved."""

from __future__ import annotations

import contextlib
import resource
import signal
import struct
import subprocess
import time
from pathlib import Path

import pytest
from bus_log import DBC
from comanip.bus.live import BusAddress, LiveBus, open_bus
from comanip.bus.operator_client import OperatorClient, RefusedError
from comanip.errors import ToolError
from comanip_command import COMANIP, WRONG_USE, call
from hub import PATIENCE_S, WITH_CAN, Hub, Tool, running, tool, wait_until
from live import FIRMWARE, INTERFACE, SLOWER, Bus, has_kernel_can
from simulation import REPOSITORY
from test_comanip_on_a_hub import comanip
from test_parameter_store import DEFAULTS, NAMES, record
from test_two_processes import PLAIN

pytestmark = pytest.mark.skipif(has_kernel_can(), reason="runs on a hub only: the bus does not matter")

SCALE = NAMES.index("motion_scale")
KILLED_BY_LIMIT = -signal.SIGXFSZ


def with_scale(value: float) -> bytes:
    return record([value if i == SCALE else default for i, default in enumerate(DEFAULTS)])


@pytest.fixture(scope="module")
def hub():
    with running("--socketcand", "0") as hub_:
        yield hub_


@pytest.fixture
def file(tmp_path) -> Path:
    return tmp_path / "parameters"


def bus_of(hub: Hub) -> LiveBus:
    return open_bus(BusAddress("socketcand", hub.bus, "127.0.0.1", hub.port))


@contextlib.contextmanager
def firmware(hub: Hub, *arguments: object):
    """Runs the firmware and an operator's client, and waits until the firmware has booted."""
    with tool(hub, FIRMWARE, "--can", hub.bus, "--slow", SLOWER, *arguments) as process, bus_of(hub) as bus:

        def answers() -> bool:
            process.require_running()
            with contextlib.suppress(ToolError):
                OperatorClient(bus, attempts=1, answer_s=1.0).read("motion_scale")
                return True
            return False

        wait_until(answers, "the firmware's answer")
        yield process, OperatorClient(bus, attempts=10, answer_s=1.0)


def end(process: Tool) -> str:
    process.process.send_signal(signal.SIGTERM)
    text = process.wait()
    assert process.process.returncode == 0, text
    return text


# ---- saved and read


def test_saved_parameters_survive_a_kill(hub, file):
    with firmware(hub, "--parameters", file) as (process, client):
        assert client.read("motion_scale") == 1
        client.write("motion_scale", 0.5)
        assert not file.exists(), "writing must not save"
        done = comanip(hub, "socketcand", "param", "save")
        assert (done.returncode, done.stderr) == (0, "") and done.stdout.startswith("saved: "), done
        assert file.read_bytes() == with_scale(0.5)
        assert [path.name for path in file.parent.iterdir()] == [file.name], "no other file must be left"
        process.process.kill()
        process.wait()
        assert f"comanip-firmware: {file} does not exist yet: all parameters have their defaults\n" in process.text()
    with firmware(hub, f"--parameters={file}") as (process, client):
        assert client.read("motion_scale") == 0.5
        assert client.read("damping") == DEFAULTS[NAMES.index("damping")]
        client.write("motion_scale", 0.25)
        client.save()
        assert f"comanip-firmware: parameters read from {file}, {len(record(DEFAULTS))} bytes\n" in end(process)
    assert file.read_bytes() == with_scale(0.25)


def test_without_a_file_there_is_no_store(hub, tmp_path):
    with firmware(hub) as (process, client):
        with pytest.raises(RefusedError, match=r"save: refused: not_supported \(.*--parameters FILE"):
            client.save()
        end(process)


@pytest.mark.parametrize("profile", ["fd", "classic"])
def test_a_run_with_stored_parameters_replays(tmp_path, profile):
    """The log of a run with a plant replays without a difference if the firmware reads its parameters from a store at
    boot, and saves them again during the run."""
    (tmp_path / "parameters").write_bytes(with_scale(0.75))
    with Bus(tmp_path, SLOWER, profile) as bus:
        plant = bus.plant("--scenario", PLAIN, "--duration", 2)
        bus.wait(lambda: "waits for the firmware" in bus.output("plant.out") or plant.poll() is not None, "the plant")
        bus.firmware("firmware", FIRMWARE, "--parameters", tmp_path / "parameters")
        bus.wait(lambda: bus.since(0, "ParameterValue"), "the boot")
        save = [WITH_CAN, COMANIP, "param", "save", "-c", INTERFACE]
        saved = subprocess.run(save, env=bus.environment, capture_output=True, text=True, check=False)
        bus.wait(lambda: plant.poll() is not None, "the plant's end")
    assert saved.returncode == 0 or "wrong_mode" in saved.stderr, "the cooperation may have started before the save"
    values = {}
    for frame in bus.since(0, "ParameterValue"):
        decoded = frame.decode()
        values.setdefault(str(decoded["parameter"]), decoded["value"])
    assert values["motion_scale"] == 0.75
    replayed = call("replay", tmp_path / "plant" / "bus.log")
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr


# ---- invalid records


def boot_results(hub: Hub, file: Path) -> tuple[set[str], dict[str, float]]:
    """Returns the results and values that the firmware announces at boot."""
    values, results = {}, set()
    command = [FIRMWARE, "--can", hub.bus, "--slow", SLOWER, "--parameters", file]
    with hub.connect() as tap, tool(hub, *command) as process:
        deadline_s = time.monotonic() + PATIENCE_S
        while len(values) < len(NAMES):
            process.require_running()
            assert time.monotonic() < deadline_s, f"not announced: {set(NAMES) - set(values)}; {process.text()}"
            packet = tap.recv(72)
            frame_id, length = struct.unpack_from("=IB", packet)
            if frame_id == DBC.get_message_by_name("ParameterValue").frame_id:
                decoded = DBC.decode_message(frame_id, packet[8 : 8 + length])
                values[str(decoded["parameter"])] = decoded["value"]
                results.add(str(decoded["result"]))
    return results, values


def test_a_valid_record_is_announced_as_accepted(hub, file):
    file.write_bytes(with_scale(0.5))
    results, values = boot_results(hub, file)
    assert (results, values["motion_scale"]) == ({"accepted"}, 0.5)


INVALID = {
    "empty": b"",
    "truncated": with_scale(0.5)[:-1],
    "one bit": bytes([*with_scale(0.5)[:100], with_scale(0.5)[100] ^ 0x20, *with_scale(0.5)[101:]]),
    "out of range": with_scale(1e6),
    "another format": record(DEFAULTS, magic=b"CMN3"),
    "longer": with_scale(0.5) + bytes(9000),
    "text": b"motion_scale = 0.5\n",
}


@pytest.mark.parametrize("kind", INVALID)
def test_an_invalid_record_gives_defaults_and_is_reported_on_the_bus(hub, file, kind):
    file.write_bytes(INVALID[kind])
    results, values = boot_results(hub, file)
    assert results == {"store_failed"}
    assert list(values.values()) == pytest.approx(DEFAULTS, rel=1e-6)
    with firmware(hub, "--parameters", file) as (process, client):
        client.write("motion_scale", 0.5)
        client.save()
        end(process)
    assert file.read_bytes() == with_scale(0.5), "a save replaces the invalid record"


# ---- interrupted saves


def is_complete(file: Path, *scales: float) -> bool:
    return file.read_bytes() in [with_scale(scale) for scale in scales]


@pytest.mark.parametrize("bytes_written", [0, 1, 11, 12, 100, len(record(DEFAULTS)) - 1])
def test_killed_during_the_write(hub, file, bytes_written):
    """The kernel kills the process (RLIMIT_FSIZE) after it has written `bytes_written` bytes. Firmware that is started
    afterwards boots and saves normally."""
    file.write_bytes(with_scale(0.5))
    with firmware(hub, "--parameters", file) as (process, client):
        client.write("motion_scale", 0.25)
        resource.prlimit(process.process.pid, resource.RLIMIT_FSIZE, (bytes_written, bytes_written))
        with pytest.raises(ToolError, match="no ParameterValue"), bus_of(hub) as bus:
            OperatorClient(bus, attempts=1).save()
        process.wait()
        assert process.process.returncode == KILLED_BY_LIMIT
    assert file.read_bytes() == with_scale(0.5)
    assert file.with_name("parameters.tmp").stat().st_size == bytes_written, "the process is killed at that byte"
    with firmware(hub, "--parameters", file) as (process, client):
        assert client.read("motion_scale") == 0.5
        client.write("motion_scale", 2)
        client.save()
        end(process)
    assert [path.name for path in file.parent.iterdir()] == [file.name]
    assert is_complete(file, 2)


WRITER = """
#include <string.h>
#include "hal/linux/record_file.h"
int main(int argc, char *argv[]) {
    char record[20000];
    (void)argc;
    for (int i = 0; ; i++) {
        const size_t length = i % 2 == 0 ? 20000 : 10000;
        memset(record, i % 2 == 0 ? 'a' : 'b', length);
        if (!record_file_write(argv[1], record, length)) { return 1; }
    }
}
"""


def test_killed_at_any_moment(tmp_path, rng):
    """A process writes two records in turn. Whenever it is killed, the file contains one of the two completely."""
    source, program, path = tmp_path / "writer.c", tmp_path / "writer", tmp_path / "records" / "record"
    source.write_text(WRITER)
    path.parent.mkdir()
    flags = ["-std=c11", "-D_DEFAULT_SOURCE", "-D_POSIX_C_SOURCE=200809L", f"-I{REPOSITORY}"]
    subprocess.run(["gcc", *flags, source, REPOSITORY / "hal/linux/record_file.c", "-o", program], check=True)
    found, interrupted = set(), 0
    for _ in range(100):
        with subprocess.Popen([program, path]) as writer:
            while not path.exists():
                assert writer.poll() is None
            time.sleep(float(rng.uniform(0, 0.01)))
            writer.kill()
        assert writer.returncode == -signal.SIGKILL
        content = path.read_bytes()
        assert content in (b"a" * 20000, b"b" * 10000)
        found.add(content[:1])
        interrupted += path.with_name("record.tmp").exists()
    assert found == {b"a", b"b"}
    assert interrupted > 10, "the process spends most of its time writing"


# ---- refused saves


@contextlib.contextmanager
def mounted(folder: Path):
    """Mounts a disk of 64 KiB."""
    folder.mkdir()
    if (
        subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", folder], capture_output=True, check=False
        ).returncode
        != 0
    ):
        pytest.skip("only root can mount a small disk")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", folder], check=True)


def require_refusal(hub: Hub, process: Tool, file: Path, cause: str) -> None:
    """Checks that bus, command and firmware console report the refusal, and that the firmware keeps running."""
    done = comanip(hub, "socketcand", "param", "save")
    assert done.returncode == WRONG_USE
    assert done.stderr.startswith("comanip: save: refused: store_failed (") and done.stderr.count("\n") == 1, (
        done.stderr
    )
    expected = f"comanip-firmware: saving the parameters failed: {file}: {cause}\n"
    assert expected in process.text()
    assert file.read_bytes() == with_scale(0.5)
    assert not file.with_name("parameters.tmp").exists()


def test_full_and_read_only_disks(hub, tmp_path):
    with mounted(tmp_path / "disk") as disk:
        file, ballast = disk / "parameters", disk / "ballast"
        file.write_bytes(with_scale(0.5))
        with firmware(hub, "--parameters", file) as (process, client):
            client.write("motion_scale", 0.25)
            with contextlib.suppress(OSError), open(ballast, "wb", buffering=0) as full:
                while full.write(bytes(4096)):
                    pass
            require_refusal(hub, process, file, "No space left on device")
            ballast.unlink()
            subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
            require_refusal(hub, process, file, "Read-only file system")
            subprocess.run(["mount", "-o", "remount,rw", disk], check=True)
            client.save()
            assert file.read_bytes() == with_scale(0.25)
            end(process)


def test_a_file_that_cannot_be_written(hub, file):
    """The file cannot be written if a folder has the name of the temporary file."""
    file.write_bytes(with_scale(0.5))
    file.with_name("parameters.tmp").mkdir()
    with firmware(hub, "--parameters", file) as (process, client):
        client.write("motion_scale", 0.25)
        with pytest.raises(RefusedError, match="save: refused: store_failed"):
            client.save()
        assert f"comanip-firmware: saving the parameters failed: {file}: Is a directory\n" in process.text()
        assert client.read("motion_scale") == 0.25, "the value still applies"
        end(process)
    assert file.read_bytes() == with_scale(0.5)


@pytest.mark.parametrize(
    ("path", "cause"), [("missing/parameters", "No such file or directory"), (".", "Is a directory")]
)
def test_a_path_that_cannot_be_one_is_refused_at_the_start(hub, tmp_path, path, cause):
    command = [FIRMWARE, "--can", hub.bus, "--parameters", tmp_path / path]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=PATIENCE_S, env=hub.environment)
    assert (done.returncode, done.stdout) == (WRONG_USE, "")
    assert done.stderr == f"comanip-firmware: --parameters '{tmp_path / path}': {cause}\n"


@pytest.mark.parametrize("arguments", [["--parameters"], ["--parameters="], ["--parameters", ""]])
def test_the_option_needs_a_file(arguments):
    done = subprocess.run(
        [FIRMWARE, "--can", "vcan0", *arguments], capture_output=True, text=True, check=False, timeout=PATIENCE_S
    )
    assert (done.returncode, done.stderr) == (
        WRONG_USE,
        "comanip-firmware: --parameters '': expected the name of a file\n",
    )
