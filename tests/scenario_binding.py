"""Builds the reader of scenario files and the checks of whether a scene is physically possible, with ODE and libccd:
``ffi, lib = load()``."""

from __future__ import annotations

import functools
from pathlib import Path

import cffi
import simulator_library

READER = ("sim/scenario/scenario", "sim/scenario/scenario_file", "sim/scenario/scenario_vary")
CHECKS = ("sim/feasibility/scenario_geometry", "sim/feasibility/scenario_water")


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    return simulator_library.load([*READER, *CHECKS], libraries=["ode", "ccd", "yaml"])


def read(path: Path) -> object:
    """Reads a file and returns its scenario_t. Raises ValueError with the error line if the file or the scene is
    invalid."""
    ffi, lib = load()
    scenario, error = ffi.new("scenario_t *"), ffi.new("char[2048]")
    if not (
        lib.scenario_load(scenario, str(path).encode(), b"", error, len(error))
        and lib.scenario_check_geometry(scenario, error, len(error))
        and lib.scenario_check_water(scenario, error, len(error))
    ):
        raise ValueError(ffi.string(error).decode(errors="replace"))
    return scenario


def check(scenario: object) -> None:
    """Raises ValueError with the error line if the scene is physically impossible."""
    ffi, lib = load()
    error = ffi.new("char[2048]")
    if not lib.scenario_check_geometry(scenario, error, len(error)):
        raise ValueError(ffi.string(error).decode(errors="replace"))
