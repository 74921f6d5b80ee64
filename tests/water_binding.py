"""Builds the water and its cups: ``ffi, lib = load()``."""

from __future__ import annotations

import functools

import cffi
import simulator_library

MODULES = (
    "sim/common/rigid_pose",
    "sim/scene/cup",
    "sim/scene/particle_contacts",
    "sim/scene/particle_solver",
    "sim/scene/water",
)


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    return simulator_library.load(MODULES)
