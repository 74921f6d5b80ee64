"""The reader of scenario files and the checks whether a scene is possible, with ODE and libccd: ``ffi, lib =
load()``."""

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
    """The scenario_t of a file with a possible scene. ValueError: the error line."""
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
    """ValueError: the error line, if the scene is impossible."""
    ffi, lib = load()
    error = ffi.new("char[2048]")
    if not lib.scenario_check_geometry(scenario, error, len(error)):
        raise ValueError(ffi.string(error).decode(errors="replace"))
