"""Compiles C sources into Python libraries for the tests; see ``load()``. The compiler warnings are those of the
product's build and are treated as errors. The undefined-behaviour sanitiser ends the process at the first error. Needs
build/generated, which ``make build`` writes.

Each source is compiled only once for all libraries and test processes. It is recompiled when the source, a header or
the command changes.
"""

from __future__ import annotations

import functools
import hashlib
import os
import subprocess
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cffi
from once import lock

REPOSITORY = Path(__file__).resolve().parents[1]
GENERATED = REPOSITORY / "build" / "generated"
BUILD = REPOSITORY / "build" / "tests"
# All firmware sources except main.c, which needs a HAL.
CORE = sorted(file for file in REPOSITORY.glob("firmware/**/*.c") if file.name != "main.c")
CORE.append(GENERATED / "comanip_dbc.c")

COMPILE = [
    os.environ.get("CC", "gcc"), "-std=c11", "-D_POSIX_C_SOURCE=200809L", "-O1", "-g", "-fPIC",
    "-fsanitize=undefined,float-cast-overflow", "-fno-sanitize-recover=all",
    "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Werror", f"-I{GENERATED}",
]  # fmt: skip
OPTIMISED = ("-O2", "-ffp-contract=off")  # for tests with long computations


def _run(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}\n{done.stderr}")


@functools.cache
def _headers() -> bytes:
    """Returns a digest of all headers that a source may include."""
    digest = hashlib.sha256()
    for folder in ("sim", "hal", "host_tools/hub", "firmware", "tests", "build/generated"):
        for file in sorted((REPOSITORY / folder).rglob("*")):
            if file.suffix in (".h", ".inc"):
                digest.update(f"{file}\n".encode() + file.read_bytes())
    return digest.digest()


def _made(target: Path, key: str, command: list[str]) -> str:
    """Builds `target` by running the command with ``-o``, unless the target exists with this key. Returns the key."""
    stamp = target.with_suffix(".key")
    with lock(target.with_suffix(".lock")):
        if not (target.exists() and stamp.exists() and stamp.read_text() == key):
            unfinished = target.with_suffix(".unfinished")
            _run([*command, "-o", str(unfinished)])
            stamp.unlink(missing_ok=True)
            unfinished.replace(target)  # not overwritten: a process may have loaded the old library
            stamp.write_text(key)
    return key


def objects(sources: Iterable[Path], compile_: list[str]) -> list[tuple[Path, str]]:
    """Compiles the sources, which must be in the repository. Returns the object file and the key of each source. The
    key is a digest of the source, the headers and the command."""
    kind = hashlib.sha256("\0".join(compile_).encode()).hexdigest()[:8]

    def compiled(source: Path) -> tuple[Path, str]:
        digest = hashlib.sha256(_headers() + source.read_bytes() + "\0".join(compile_).encode())
        target = (BUILD / "objects" / kind / source.relative_to(REPOSITORY)).with_suffix(".o")
        return target, _made(target, digest.hexdigest(), [*compile_, "-c", str(source)])

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(compiled, sources))


def load(
    name: str, declared: str, sources: Iterable[Path], *options: str, libraries: Iterable[str] = ()
) -> tuple[cffi.FFI, object]:
    """Compiles and links the sources and returns ``ffi, lib``. declared: the C declarations that cffi makes visible to
    Python. options: compiler options to add to COMPILE. libraries: libraries to link in addition to libm, named as for
    the linker's -l. Raises RuntimeError with the compiler's output if a command fails."""
    ffi = cffi.FFI()
    ffi.cdef(declared)
    compile_ = [*COMPILE, *options]
    parts = objects(sources, compile_)
    link = [*compile_, "-shared", "-Wl,-z,defs", *(str(target) for target, _ in parts)]
    link += [*(f"-l{library}" for library in libraries), "-lm"]
    digest = hashlib.sha256("\0".join([*link, *(key for _, key in parts)]).encode())
    library = BUILD / f"{name}.so"
    _made(library, digest.hexdigest(), link)
    return ffi, ffi.dlopen(str(library))
