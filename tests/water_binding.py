"""The water and its cups as a Python library: ``ffi, lib = load()``. Needs ODE."""

from __future__ import annotations

import functools

import c_library
import cffi
from c_declarations import declarations
from c_library import OPTIMISED, REPOSITORY

PARTS = ("common/rigid_pose", "scene/cup", "scene/particle_contacts", "scene/water")
SOURCES = [REPOSITORY / "sim" / f"{part}.c" for part in PARTS]
HEADERS = [source.with_suffix(".h") for source in SOURCES if source.stem != "particle_contacts"]  # needs ODE's headers

ODE_RANDOM = "unsigned long dRandGetSeed(void); void dRandSetSeed(unsigned long);"


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    """Optimised: the tests pour for many seconds."""
    return c_library.load("water", declarations(HEADERS) + ODE_RANDOM, SOURCES, *OPTIMISED, libraries=["ode"])
