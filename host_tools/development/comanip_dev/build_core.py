"""Compiles the firmware into the extension module ``comanip._core``.

``python -m comanip_dev.build_core --generated DIR --build-dir DIR --cflags FLAGS`` must run after comanip_dev.codegen
has written the generated CAN sources. The declarations for Python come from the firmware's preprocessed headers, not
from a copy that could differ from the headers. When the module is loaded, cffi checks that its layout of every struct
is that of the compiler.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import shlex
import subprocess
import sysconfig
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cffi

from comanip_dev import REPOSITORY

PACKAGE = REPOSITORY / "host_tools" / "comanip"
FIRMWARE = REPOSITORY / "firmware"
BINDING = PACKAGE / "_binding"

SHARED = ["-g", "-fPIC", "-fvisibility=hidden"]


def compiler() -> list[str]:
    return shlex.split(os.environ.get("CC", "gcc"))


def run(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"build_core: {shlex.join(command)}\n{done.stderr}")
    return done.stdout


def core_sources() -> list[Path]:
    """Returns all C sources of the binding and of the firmware, except main.c, which needs a HAL."""
    return sorted(source for source in FIRMWARE.rglob("*.c") if source.name != "main.c") + sorted(BINDING.glob("*.c"))


def umbrella(sources: list[Path]) -> str:
    """Returns a C source with an include line for the header of each of these sources, if it has a header."""
    headers = [source.with_suffix(".h") for source in sources]
    return "".join(f'#include "{header}"\n' for header in headers if header.is_file())


def preprocessed(includes: str, folder: Path, *options: str) -> str:
    """Returns the preprocessed headers for cffi. Leaves out the standard headers, because cffi knows their types.
    Replaces inline functions by declarations, because cffi does not parse bodies."""
    source = folder / "umbrella.c"
    source.write_text(includes)
    no_headers = folder / "no_headers"
    no_headers.mkdir(exist_ok=True)
    for name in ("stdint.h", "stdbool.h", "stddef.h", "stdio.h", "string.h", "stdatomic.h"):
        (no_headers / name).touch()
    text = run([*compiler(), "-E", "-nostdinc", f"-I{no_headers}", *options, str(source)])
    return re.sub(r"^static inline ([^{;]*?) \{.*?^\}", r"\1;", text, flags=re.MULTILINE | re.DOTALL)


def declarations(includes: str, generated: Path, build_dir: Path) -> str:
    """Returns the declarations for cffi: the preprocessed headers, and the macros that are numeric constants."""
    text = preprocessed(includes, build_dir, f"-I{generated}", "-P")
    macros = preprocessed(includes, build_dir, f"-I{generated}", "-dM", "-undef")
    integers = re.findall(r"^#define ([A-Z]\w+) \(?-?(?:0x[0-9A-Fa-f]+|\d+)u?\)?$", macros, re.MULTILINE)
    floats = re.findall(r"^#define ([A-Z]\w+) -?\d+\.\d*f$", macros, re.MULTILINE)
    return "\n".join(
        [text, *(f"#define {name} ..." for name in integers), *(f"static const float {name};" for name in floats)]
    )


def build(generated: Path, build_dir: Path, core_flags: list[str], folder: Path = PACKAGE) -> Path:
    """Builds the module in `folder`. Raises SystemExit if something does not compile."""
    if not (generated / "comanip_dbc.c").is_file():
        raise SystemExit(
            f"build_core: {generated}/comanip_dbc.c is missing: run python -m comanip_dev.codegen {generated} first"
        )
    build_dir.mkdir(parents=True, exist_ok=True)
    sources = core_sources()
    includes = umbrella(sources)

    ffi = cffi.FFI()
    ffi.cdef(declarations(includes, generated, build_dir))
    ffi.set_source("comanip._core", includes)
    module = build_dir / "_core.c"
    with contextlib.redirect_stdout(None):
        ffi.emit_c_code(str(module))

    strict = [*compiler(), *core_flags, *SHARED, f"-I{generated}"]
    common = [flag for flag in strict if not flag.startswith("-W")]  # generated code may cause warnings
    python_headers = {f"-I{sysconfig.get_path(key)}" for key in ("include", "platinclude")}
    jobs = [(strict, source) for source in sources]
    jobs += [(common, generated / "comanip_dbc.c"), ([*common, *sorted(python_headers)], module)]

    def compile_one(job: tuple[list[str], Path]) -> str:
        command, source = job
        target = build_dir / f"{source.stem}.o"
        run([*command, "-c", str(source), "-o", str(target)])
        return str(target)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        objects = list(pool.map(compile_one, jobs))

    library = folder / "_core.abi3.so"
    unfinished = build_dir / library.name
    run([*compiler(), "-shared", *objects, "-o", str(unfinished)])
    # Replaced atomically, so that a process that has loaded the old module keeps it.
    temporary = library.with_suffix(".tmp")
    temporary.write_bytes(unfinished.read_bytes())
    temporary.replace(library)
    return library


def main() -> None:
    parser = argparse.ArgumentParser(description="Compiles the firmware into the Python module comanip._core.")
    parser.add_argument("--generated", type=Path, required=True, help="folder of the sources that codegen.py wrote")
    parser.add_argument("--build-dir", type=Path, required=True, help="folder for objects and intermediate files")
    parser.add_argument("--cflags", required=True, help="compiler flags: standard, optimisation, warnings")
    parser.add_argument("--folder", type=Path, default=PACKAGE, help="folder of the module (default: the package)")
    arguments = parser.parse_args()
    folder = arguments.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    build(arguments.generated.resolve(), arguments.build_dir.resolve(), shlex.split(arguments.cflags), folder)


if __name__ == "__main__":
    main()
