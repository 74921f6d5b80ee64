"""Tests processor-in-the-loop runs: the image in QEMU, stepped by the simulator, must produce the same run as the
firmware on the host, byte for byte. These tests run for a few seconds only; `make pil` runs whole scenarios."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from images import IMAGES, Image, make
from simulation import EXIT_WRONG_USE, PATIENCE_S, REPOSITORY, experiment, run
from test_target import TESTED

PROGRAM = REPOSITORY / "build" / "host" / "comanip-pil"


def pil(*arguments: object) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "comanip_dev.images.pil", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=PATIENCE_S)


@pytest.fixture(scope="module", params=TESTED)
def image(request) -> Image:
    return IMAGES[request.param]


def build(image: Image, elf: Path, *options: str) -> Path:
    if shutil.which(image.emulator[0]) is None:
        pytest.skip(f"{image.emulator[0]} is not installed: make target-deps")
    missing = make("target-check")
    if missing.returncode != 0:
        pytest.skip(missing.stderr.strip())
    built = make(str(elf.relative_to(REPOSITORY)), str(PROGRAM.relative_to(REPOSITORY)), *options)
    assert built.returncode == 0 and built.stderr == "", built.stderr
    return elf


@pytest.fixture(scope="module")
def elf(image) -> Path:
    return build(image, REPOSITORY / "build" / "target" / f"{image.name}-pil" / "comanip.elf")


def test_the_run_equals_the_hosts_byte_for_byte(image, elf, tmp_path):
    """The runs are equal from boot to the operator's stop, including the cooperation, in which the arm follows the
    moving hand."""
    options = ["--scenario", experiment("teleop"), "--duration", 2, "--quiet"]
    done = pil(" ".join(image.emulator), elf, PROGRAM, "--out", tmp_path / "pil", *options)
    host = run(tmp_path / "host", *options[:-1])
    assert (done.returncode, done.stderr) == (host.status, host.stderr), done.stdout
    assert (tmp_path / "pil" / "bus.log").read_bytes() == host.log.read_bytes()
    assert (tmp_path / "pil" / "trace.csv").read_bytes() == host.trace.read_bytes()
    assert {mode["mode"] for mode in host.summary["modes"]} >= {"ready", "cooperating"}


def test_the_run_on_classic_can_equals_the_hosts(tmp_path):
    image = IMAGES["cortex-m4f"]
    elf = build(image, REPOSITORY / "build" / "target-classic" / f"{image.name}-pil" / "comanip.elf", "PROFILE=classic")
    options = ["--scenario", experiment("teleop"), "--duration", 2, "--profile", "classic", "--quiet"]
    done = pil(" ".join(image.emulator), elf, PROGRAM, "--out", tmp_path / "pil", *options)
    host = run(tmp_path / "host", *options[:-1])
    assert (done.returncode, done.stderr) == (host.status, host.stderr), done.stdout
    assert (tmp_path / "pil" / "bus.log").read_bytes() == host.log.read_bytes()


def test_an_image_that_panics_ends_the_run_with_its_message(image, elf, tmp_path):
    source = tmp_path / "panics.c"
    source.write_text(
        f'#include "{REPOSITORY}/hal/hal.h"\n#include "{REPOSITORY}/firmware/main.h"\n'
        "void firmware_main(void) {\n    hal_init();\n    uint32_t now_us;\n"
        '    for (int i = 0; i < 5 && hal_wait_tick(&now_us); i++) {\n    }\n    hal_panic("as planned");\n}\n'
    )
    panics = tmp_path / "build" / f"{image.name}-pil" / "comanip.elf"
    built = make(str(panics), "CORE_SOURCES=", f"TARGET_MAIN={source}", f"TARGET_BUILD={tmp_path}/build")
    assert built.returncode == 0, built.stderr
    done = pil(" ".join(image.emulator), panics, PROGRAM, "--out", tmp_path / "out", "--duration", 2, "--quiet")
    assert done.returncode == 1
    assert "firmware panic: as planned" in done.stderr


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_all_processes(elf, image, tmp_path, number):
    """A signal ends the process group, which includes emulator and simulator. The interrupted run still writes its
    summary."""
    command = [
        sys.executable,
        "-m",
        "comanip_dev.images.pil",
        " ".join(image.emulator),
        elf,
        PROGRAM,
        "--out",
        tmp_path / "out",
    ]
    with subprocess.Popen(
        list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, start_new_session=True
    ) as process:
        try:
            assert "in qemu-system" in process.stdout.readline()
            deadline_s = time.monotonic() + PATIENCE_S
            while not list((tmp_path / "out").glob("bus.log*")) and time.monotonic() < deadline_s:
                time.sleep(0.1)  # wait until the run has started
            process.send_signal(number)
            assert process.wait(PATIENCE_S) == 128 + number
        except BaseException:
            os.killpg(process.pid, signal.SIGKILL)
            raise
    with pytest.raises(ProcessLookupError):
        os.killpg(process.pid, 0)
    assert (tmp_path / "out" / "summary.json").exists()


def test_wrong_use(tmp_path):
    assert pil().returncode == EXIT_WRONG_USE
    refused = pil("no-such-emulator -machine x", "x.elf", PROGRAM)
    assert refused.returncode == EXIT_WRONG_USE and "no-such-emulator is not installed" in refused.stderr
    built = make(str(PROGRAM.relative_to(REPOSITORY)))  # needs no compiler for the target
    assert built.returncode == 0, built.stderr
    if shutil.which("qemu-system-arm"):
        missing = pil(
            "qemu-system-arm -machine mps2-an386", tmp_path / "none.elf", PROGRAM, "--out", tmp_path / "out", "--quiet"
        )
        assert missing.returncode != 0 and "none.elf" in missing.stderr
    alone = subprocess.run([PROGRAM, "--serial", tmp_path / "nothing"], capture_output=True, text=True, check=False)
    assert alone.returncode == EXIT_WRONG_USE and "cannot connect to the serial line" in alone.stderr
    no_board = make("pil", "BOARD=arduino")
    assert no_board.returncode != 0 and "BOARD='arduino': expected one of" in no_board.stderr
