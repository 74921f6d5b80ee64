"""Finds the test files that use the compiled core: those whose imports lead to ``comanip._core``."""

from __future__ import annotations

import ast
import functools
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
TESTS = REPOSITORY / "tests"
# tests/rest has a loop around the core that is compiled on its own.
FOLDERS = (
    REPOSITORY / "host_tools",
    REPOSITORY / "host_tools" / "development",
    TESTS,
    TESTS / "rest",
    TESTS / "bitexact",
)
CORES = {"comanip._core", "rest_loop"}
# The firmware runs as a separate process there, which is not sanitised, and timeouts decide the outcome.
OTHER_PROCESSES = {"test_comanip_on_a_hub.py", "test_two_processes.py"}


@functools.cache
def source(module: str) -> Path | None:
    """The file of a module of ours."""
    inner = Path(*module.split("."))
    places = (folder / place for folder in FOLDERS for place in (inner.with_suffix(".py"), inner / "__init__.py"))
    return next((place for place in places if place.is_file()), None)


@functools.cache
def imports(file: Path) -> frozenset[str]:
    """What it names, also within functions. Of `from a import b` both a and a.b, of which one may be no module."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return frozenset(found)


def uses_core(file: Path) -> bool:
    seen, ahead = set(), [file]
    while ahead:
        named = imports(ahead.pop()) - seen
        if named & CORES:
            return True
        seen |= named
        ahead += [path for module in named if (path := source(module))]
    return False


def test_files() -> list[Path]:
    return sorted(file for file in TESTS.glob("test_*.py") if file.name not in OTHER_PROCESSES and uses_core(file))
