"""The water and its cups as a Python library: ``ffi, lib = load()``. Needs nothing but the C library."""

from __future__ import annotations

import functools

import c_library
import cffi
from c_declarations import declarations
from c_library import OPTIMISED, REPOSITORY

PARTS = ("common/rigid_pose", "scene/cup", "scene/particle_contacts", "scene/particle_solver", "scene/water")
SOURCES = [REPOSITORY / "sim" / f"{part}.c" for part in PARTS]
HEADERS = [source.with_suffix(".h") for source in SOURCES]


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    """Optimised: the tests pour for many seconds."""
    return c_library.load("water", declarations(HEADERS), SOURCES, *OPTIMISED)
