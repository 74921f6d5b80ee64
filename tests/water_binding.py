"""The water and its cups as a Python library: ``ffi, lib = load()``. Needs ODE and build/generated."""

from __future__ import annotations

import functools
import subprocess
import tempfile
from pathlib import Path

import cffi
from c_declarations import declarations
from sim_binding import BUILD, COMPILE, REPOSITORY

PARTS = ("common/rigid_pose", "scene/cup", "scene/particle_contacts", "scene/water")
SOURCES = [REPOSITORY / "sim" / f"{part}.c" for part in PARTS]
HEADERS = [source.with_suffix(".h") for source in SOURCES if source.stem != "particle_contacts"]  # needs ODE's headers

ODE_RANDOM = "unsigned long dRandGetSeed(void); void dRandSetSeed(unsigned long);"


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    """Compiled anew in each test run: a few seconds, and never stale. Optimised: the tests pour for many seconds."""
    BUILD.mkdir(parents=True, exist_ok=True)
    ffi = cffi.FFI()
    with tempfile.TemporaryDirectory(dir=BUILD) as name:
        folder = Path(name)
        ffi.cdef(declarations(HEADERS) + ODE_RANDOM)
        library = folder / "water.so"
        command = [*COMPILE, "-O2", "-ffp-contract=off", "-shared", *map(str, SOURCES)]
        command += ["-lode", "-lm", "-o", str(library)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}\n{done.stderr}")
        return ffi, ffi.dlopen(str(library))
