"""The reader of scenario files as a Python library: ``ffi, lib = load()``.
Needs ODE, libccd and libyaml."""

from __future__ import annotations

import functools
from pathlib import Path

import c_library
import cffi
from c_declarations import declarations
from c_library import CORE, REPOSITORY

SIM = REPOSITORY / "sim"
HEADERS = [SIM / "scenario" / f"{name}.h" for name in ("scenario", "scenario_file", "scenario_geometry")]
FOLDERS = ("common", "robot", "scenario", "scene", "proximity")
NOT_NEEDED = ("person_program.c", "proximity.c")  # they pull in the people's hands and the bus


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    sources = [file for name in FOLDERS for file in sorted((SIM / name).glob("*.c")) if file.name not in NOT_NEEDED]
    return c_library.load("scenario", declarations(HEADERS), sources + CORE, libraries=("ode", "ccd", "yaml"))


def read(path: Path) -> object:
    """The scenario_t of a file. ValueError: the reader's line."""
    ffi, lib = load()
    scenario, error = ffi.new("scenario_t *"), ffi.new("char[2048]")
    if not lib.scenario_load(scenario, str(path).encode(), b"", error, len(error)):
        raise ValueError(ffi.string(error).decode(errors="replace"))
    return scenario


def check(scenario: object) -> None:
    """ValueError: what cannot be, as its line says."""
    ffi, lib = load()
    error = ffi.new("char[2048]")
    if not lib.scenario_check_geometry(scenario, error, len(error)):
        raise ValueError(ffi.string(error).decode(errors="replace"))
