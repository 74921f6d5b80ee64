"""Provides the target images, as listed by `make images`, which reads each port's images.mk."""

from __future__ import annotations

import contextlib
import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

from once import lock

REPOSITORY = Path(__file__).resolve().parents[1]
MAKE_LOCK = REPOSITORY / "build" / "tests" / "make.lock"


@dataclass(frozen=True)
class Image:
    """A target image. `prefix` is the prefix of the compiler's name, `specs` the specs file that selects the libc, and
    `cpu` the compiler's options for the processor core. `emulator` is the command that runs the image in an emulator,
    empty if no emulator supports the board. `can` is "slcan" if CAN goes over a serial line, through which the tests
    talk to the image."""

    name: str
    board: str
    prefix: str
    specs: str
    cpu: list[str]
    emulator: list[str]
    can: str

    @property
    def is_arm(self) -> bool:
        return self.prefix.startswith("arm")


def make(*arguments: str) -> subprocess.CompletedProcess:
    """Runs make. A lock ensures that two runs in the build folder never overlap, even if different test processes start
    them. A run in a test's own folder (TARGET_BUILD) needs no lock."""
    elsewhere = any(argument.startswith("TARGET_BUILD=") for argument in arguments)
    with contextlib.nullcontext() if elsewhere else lock(MAKE_LOCK):
        return _make(*arguments)


def _make(*arguments: str) -> subprocess.CompletedProcess:
    # Drop the variables of the make that runs the tests. Its job server is not available to this process, so make would
    # print a warning.
    environment = {
        name: value for name, value in os.environ.items() if name not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")
    }
    return subprocess.run(
        ["make", "-s", *arguments], cwd=REPOSITORY, capture_output=True, text=True, check=False, env=environment
    )


def read() -> dict[str, Image]:
    rows = (line.split("\t") for line in make("images").stdout.splitlines())
    return {name: Image(name, board, prefix, specs, cpu.split(), emulator.split(), can)
            for name, board, prefix, specs, cpu, emulator, can in rows}  # fmt: skip


IMAGES = read()
EMULATED = [name for name, image in IMAGES.items() if image.emulator]
SERIAL = [name for name in EMULATED if IMAGES[name].can == "slcan"]
