"""The water and its cups as a Python library: ``ffi, lib = load()``. Needs ODE and build/generated."""

from __future__ import annotations

import functools
import subprocess
import tempfile
from pathlib import Path

import cffi
from sim_binding import BUILD, COMPILE, REPOSITORY

PARTS = ("common/rigid_pose", "scene/cup", "scene/particle_contacts", "scene/water")
SOURCES = [REPOSITORY / "sim" / f"{part}.c" for part in PARTS]
HEADERS = [source.with_suffix(".h") for source in SOURCES if source.stem != "particle_contacts"]  # needs ODE's headers

ODE_RANDOM = "unsigned long dRandGetSeed(void); void dRandSetSeed(unsigned long);"


def _declarations(folder: Path) -> str:
    for name in ("stdint.h", "stdbool.h", "stddef.h"):
        (folder / name).write_text("")
    umbrella = folder / "umbrella.h"
    umbrella.write_text("".join(f'#include "{header}"\n' for header in HEADERS))
    command = [COMPILE[0], "-E", "-P", "-nostdinc", f"-I{folder}", str(umbrella)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    """Compiled anew in each test run: a few seconds, and never stale. Optimised: the tests pour for many seconds."""
    BUILD.mkdir(parents=True, exist_ok=True)
    ffi = cffi.FFI()
    with tempfile.TemporaryDirectory(dir=BUILD) as name:
        folder = Path(name)
        ffi.cdef(_declarations(folder) + ODE_RANDOM)
        library = folder / "water.so"
        command = [*COMPILE, "-O2", "-ffp-contract=off", "-shared", *map(str, SOURCES)]
        command += ["-lode", "-lm", "-o", str(library)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}\n{done.stderr}")
        return ffi, ffi.dlopen(str(library))
