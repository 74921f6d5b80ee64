"""The simulated arm, its drives and the monitors as a Python library: ``ffi, lib = load()``. Needs ODE and build/generated."""

from __future__ import annotations

import functools
import subprocess
import tempfile
from pathlib import Path

import cffi
from sim_binding import BUILD, COMPILE, FIRMWARE, REPOSITORY

PARTS = (
    "bus/bus", "bus/frame_time", "common/names", "common/rigid_pose", "monitors/limit_monitor", "monitors/reach",
    "nodes/drive_node", "robot/arm_plant", "robot/robot_model",
)  # fmt: skip


def _declarations(folder: Path) -> str:
    for name in ("stdint.h", "stdbool.h", "stddef.h"):
        (folder / name).write_text("")
    umbrella = folder / "umbrella.h"
    umbrella.write_text("".join(f'#include "{REPOSITORY / "sim" / part}.h"\n' for part in PARTS))
    command = [COMPILE[0], "-E", "-P", "-nostdinc", f"-I{folder}", str(umbrella)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    """Compiled anew in each test run: a few seconds, and never stale."""
    BUILD.mkdir(parents=True, exist_ok=True)
    sources = [str(REPOSITORY / "sim" / f"{part}.c") for part in PARTS]
    sources += sorted(str(file) for file in FIRMWARE if file.name != "main.c")
    ffi = cffi.FFI()
    with tempfile.TemporaryDirectory(dir=BUILD) as name:
        folder = Path(name)
        ffi.cdef(_declarations(folder))
        library = folder / "plant.so"
        command = [*COMPILE, "-shared", *sources, "-lode", "-lm", "-o", str(library)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}\n{done.stderr}")
        return ffi, ffi.dlopen(str(library))
