"""Finds the test files that import the compiled core ``comanip._core``, directly or through other modules."""

from __future__ import annotations

import ast
import functools
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
TESTS = REPOSITORY / "tests"
FOLDERS = (
    REPOSITORY / "host_tools",
    REPOSITORY / "host_tools" / "development",
    TESTS,
    TESTS / "rest",
    TESTS / "bitexact",
)
# Compiled modules that contain the core: the core itself, and the loop in tests/rest, which is built separately.
CORES = {"comanip._core", "rest_loop"}
# These tests are left out, because the firmware runs in a separate process that is not sanitised, and because their
# outcome depends on timeouts.
OTHER_PROCESSES = {"test_comanip_on_a_hub.py", "test_two_processes.py"}


@functools.cache
def source(module: str) -> Path | None:
    """Returns the file of a module in this repository, or None for any other module."""
    inner = Path(*module.split("."))
    places = (folder / place for folder in FOLDERS for place in (inner.with_suffix(".py"), inner / "__init__.py"))
    return next((place for place in places if place.is_file()), None)


@functools.cache
def imports(file: Path) -> frozenset[str]:
    """Returns the modules that the file imports, including those within functions. For `from a import b` returns both a
    and a.b, although a.b need not be a module."""
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
