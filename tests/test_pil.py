"""Processor in the loop: the image in QEMU, stepped by the simulator, makes the same run as the firmware on the host, byte for
byte. A few seconds of it; `make pil` runs whole scenarios."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from simulation import EXIT_WRONG_USE, REPOSITORY, experiment, run
from test_target import TESTED, make

BOARDS = {
    "mps2-an385": ("cortex-m3-pil", "qemu-system-arm"),
    "mps2-an386": ("cortex-m4f-pil", "qemu-system-arm"),
    "mps2-an500": ("cortex-m7-pil", "qemu-system-arm"),
    "virt": ("rv32imac-pil", "qemu-system-riscv32"),
}
PROGRAM = REPOSITORY / "build" / "host" / "comanip-pil"
TIMEOUT_S = 300


def pil(*arguments: object) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "comanip.pil", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=TIMEOUT_S)


@pytest.fixture(scope="module", params=[board for board, (image, _) in BOARDS.items() if image.removesuffix("-pil") in TESTED])
def board(request) -> tuple[str, Path]:
    """Its name, and the image for it."""
    image, emulator = BOARDS[request.param]
    if shutil.which(emulator) is None:
        pytest.skip(f"{emulator} is not installed: make target-deps")
    missing = make("target-check")
    if missing.returncode != 0:
        pytest.skip(missing.stderr.strip())
    elf = REPOSITORY / "build" / "target" / image / "comanip.elf"
    built = make(str(elf.relative_to(REPOSITORY)), str(PROGRAM.relative_to(REPOSITORY)))
    assert built.returncode == 0 and built.stderr == "", built.stderr
    return request.param, elf


def test_the_run_is_the_hosts_byte_for_byte(board, tmp_path):
    """From boot into cooperation: the hand moves, the arm follows, the operator stops it."""
    name, elf = board
    options = ["--scenario", experiment("teleop"), "--duration", 2, "--quiet"]
    done = pil(name, elf, PROGRAM, "--out", tmp_path / "pil", *options)
    host = run(tmp_path / "host", *options[:-1])
    assert (done.returncode, done.stderr) == (host.status, host.stderr), done.stdout
    assert (tmp_path / "pil" / "bus.log").read_bytes() == host.log.read_bytes()
    assert (tmp_path / "pil" / "trace.csv").read_bytes() == host.trace.read_bytes()
    assert {mode["mode"] for mode in host.summary["modes"]} >= {"ready", "cooperating"}


def test_an_image_that_panics_ends_the_run_with_its_words(board, tmp_path):
    name, _ = board
    image, _ = BOARDS[name]
    source = tmp_path / "panics.c"
    source.write_text(
        f'#include "{REPOSITORY}/hal/hal.h"\n#include "{REPOSITORY}/firmware/main.h"\n'
        "void firmware_main(void) {\n    hal_init();\n    uint32_t now_us;\n"
        '    for (int i = 0; i < 5 && hal_wait_tick(&now_us); i++) {\n    }\n    hal_panic("as planned");\n}\n'
    )
    elf = tmp_path / "build" / image / "comanip.elf"
    built = make(str(elf), "CORE_SOURCES=", f"TARGET_MAIN={source}", f"TARGET_BUILD={tmp_path}/build")
    assert built.returncode == 0, built.stderr
    done = pil(name, elf, PROGRAM, "--out", tmp_path / "out", "--duration", 2, "--quiet")
    assert done.returncode == 1
    assert "firmware panic: as planned" in done.stderr


def test_wrong_use(tmp_path):
    assert pil().returncode == EXIT_WRONG_USE
    refused = pil("arduino", "x.elf", PROGRAM)
    assert refused.returncode == EXIT_WRONG_USE and "mps2-an385, mps2-an386, mps2-an500, virt" in refused.stderr
    alone = subprocess.run([PROGRAM, "--serial", tmp_path / "nothing"], capture_output=True, text=True, check=False)
    assert alone.returncode == EXIT_WRONG_USE and "no serial line there" in alone.stderr
    no_board = make("pil", "BOARD=arduino")
    assert no_board.returncode != 0 and "BOARD='arduino': expected one of mps2-an385 mps2-an386 mps2-an500 virt" in no_board.stderr
