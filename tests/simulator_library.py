"""Builds the simulator modules under test, with the modules they need, as a Python library.

A module under test is named like ``sim/bus/bus``. Its header is declared to Python and its object is linked. The linker
takes all other objects from an archive of the whole simulator, unless a stand-in (a source in tests/) defines their
functions.
"""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterable
from pathlib import Path

import cffi
from c_declarations import declarations
from c_library import COMPILE, CORE, OPTIMISED, REPOSITORY, objects

COMMAND = [*COMPILE, *OPTIMISED]
# All sources except the programs and the modules that only a program needs: sim/port, which connects the simulator to
# the firmware, and the live bus.
SOURCES = [
    *(file for file in sorted(REPOSITORY.glob("sim/*/*.c")) if file.parent.name not in ("programs", "port")),
    *(REPOSITORY / name for name in ("hal/common/frame_time.c", "hal/linux/hub_path.c")),
    *CORE,
]
SOURCES.remove(REPOSITORY / "sim/bus/live_bus.c")


def _run(command: Iterable[object]) -> None:
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(done.args)}\n{done.stderr}")


def link(library: Path, modules: Iterable[str], libraries: Iterable[str] = ()) -> None:
    """Links the modules with the objects they need from the archive and with the libraries ("ode", "ccd", ...). Raises
    RuntimeError if something is missing."""
    named = [file for module in modules if (file := REPOSITORY / f"{module}.c").is_file()]  # some have only a header
    named, rest = ([part for part, _ in objects(sources, COMMAND)] for sources in (named, SOURCES))
    archive = library.with_suffix(".a")
    _run(["ar", "rcsT", archive, *rest])
    _run(
        [
            *COMMAND,
            "-shared",
            "-Wl,-z,defs",
            *named,
            archive,
            *(f"-l{name}" for name in libraries),
            "-lm",
            "-o",
            library,
        ]
    )


def load(
    modules: Iterable[str], stand_ins: Iterable[str] = (), libraries: Iterable[str] = (), declared: str = ""
) -> tuple[cffi.FFI, object]:
    """Builds the library and returns ``ffi, lib``. `declared`: declarations of library functions that the test itself
    calls."""
    ffi = cffi.FFI()
    named = [*modules, *stand_ins]
    headers = [REPOSITORY / f"{module}.h" for module in named]
    ffi.cdef(declarations(file for file in headers if file.is_file()) + declared)
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "library.so"
        link(library, named, libraries)
        return ffi, ffi.dlopen(str(library))
