"""The reader of scenario files as a Python library: ``ffi, lib = load()``. Needs ODE, libccd, libyaml and build/generated."""

from __future__ import annotations

import functools
import os
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cffi
from c_declarations import declarations
from sim_binding import BUILD, COMPILE, FIRMWARE, REPOSITORY

SIM = REPOSITORY / "sim"
HEADERS = [SIM / "scenario" / f"{name}.h" for name in ("scenario", "scenario_file", "scenario_geometry")]
FOLDERS = ("common", "robot", "scenario", "scene", "proximity")
NOT_NEEDED = ("person_program.c", "proximity.c")  # they pull in the people's hands and the bus


def _compile(folder: Path) -> Path:
    sources = [file for name in FOLDERS for file in sorted((SIM / name).glob("*.c")) if file.name not in NOT_NEEDED]
    sources += sorted(file for file in FIRMWARE if file.name != "main.c")

    def run(command: list[str]) -> None:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}\n{done.stderr}")

    def compile_one(source: Path) -> str:
        run([*COMPILE, "-c", str(source), "-o", str(folder / f"{source.stem}.o")])
        return str(folder / f"{source.stem}.o")

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        objects = list(pool.map(compile_one, sources))
    library = folder / "scenario.so"
    run([*COMPILE, "-shared", "-Wl,-z,defs", *objects, "-lode", "-lccd", "-lyaml", "-lm", "-o", str(library)])
    return library


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    """Compiled anew in each test run: a few seconds, and never stale."""
    BUILD.mkdir(parents=True, exist_ok=True)
    ffi = cffi.FFI()
    with tempfile.TemporaryDirectory(dir=BUILD) as name:
        ffi.cdef(declarations(HEADERS))
        return ffi, ffi.dlopen(str(_compile(Path(name))))


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
