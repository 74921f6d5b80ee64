"""The simulator's parts without ODE, and stand_in_scene.c in its place, as a Python library: ``ffi, lib = load()``.

Compiled from the sources with the product's warnings as errors, and with the undefined-behaviour sanitiser, which ends
the process at the first fault. Needs build/generated, which ``make build`` writes.
"""

from __future__ import annotations

import functools
import hashlib
import os
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cffi
from c_declarations import declarations

REPOSITORY = Path(__file__).resolve().parents[1]
GENERATED = REPOSITORY / "build" / "generated"
BUILD = REPOSITORY / "build" / "tests"

PARTS = [
    REPOSITORY / "sim" / name
    for name in (
        "bus/bus", "bus/candump_log", "bus/frame_time", "common/events", "common/names", "common/random",
        "common/rigid_pose", "people/approach", "people/crank_turn", "hand/hand_history", "hand/hand_path",
        "hand/minimum_jerk", "hand/playback", "people/playlist", "hand/recorded_motion", "hand/recording", "people/sight",
        "scenario/forbidden_drop", "scenario/step_wait", "hand/tremor", "nodes/operator_node", "nodes/operator_script", "nodes/tracker_node",
        "people/person_program",
    )
] + [REPOSITORY / "tests" / "stand_in_scene"]  # fmt: skip
FIRMWARE = [*REPOSITORY.glob("firmware/**/*.c"), GENERATED / "comanip_dbc.c"]
ENDPOINT = REPOSITORY / "sim" / "bus" / "endpoint.c"
SOURCES = (
    [part.with_suffix(".c") for part in PARTS] + [ENDPOINT] + sorted(file for file in FIRMWARE if file.name != "main.c")
)
HEADERS = [part.with_suffix(".h") for part in PARTS]

COMPILE = [
    os.environ.get("CC", "gcc"), "-std=c11", "-D_POSIX_C_SOURCE=200809L", "-O1", "-g", "-fPIC",
    "-fsanitize=undefined,float-cast-overflow", "-fno-sanitize-recover=all",
    "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Werror", f"-I{GENERATED}",
]  # fmt: skip


def _run(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}\n{done.stderr}")
    return done.stdout


def _fingerprint() -> str:
    digest = hashlib.sha256(" ".join(COMPILE).encode())
    for folder in (REPOSITORY / "sim", REPOSITORY / "firmware", REPOSITORY / "tests", GENERATED):
        for file in sorted(folder.rglob("*.[ch]")):
            digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def _compile(library: Path, folder: Path) -> None:
    def compile_one(source: Path) -> str:
        target = folder / f"{source.stem}.o"
        _run([*COMPILE, "-c", str(source), "-o", str(target)])
        return str(target)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        objects = list(pool.map(compile_one, SOURCES))
    unfinished = folder / library.name
    _run([*COMPILE, "-shared", "-Wl,-z,defs", *objects, "-lm", "-o", str(unfinished)])
    unfinished.replace(library)


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    BUILD.mkdir(parents=True, exist_ok=True)
    library = BUILD / f"sim-{_fingerprint()}.so"
    ffi = cffi.FFI()
    with tempfile.TemporaryDirectory(dir=BUILD) as folder:
        ffi.cdef(declarations(HEADERS))
        if not library.exists():
            _compile(library, Path(folder))
    return ffi, ffi.dlopen(str(library))
