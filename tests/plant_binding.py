"""The simulated arm in its physical scene, its drives and the monitors as a Python library: ``ffi, lib = load()``.
Needs ODE and build/generated."""

from __future__ import annotations

import functools
import subprocess
import tempfile
from pathlib import Path

import cffi
from c_declarations import declarations
from sim_binding import BUILD, COMPILE, FIRMWARE, REPOSITORY

PARTS = (
    "bus/bus", "bus/frame_time", "common/events", "common/names", "common/rigid_pose", "common/solve_3x3", "monitors/limit_monitor",
    "monitors/reach", "nodes/drive_node", "robot/arm_plant", "robot/position_jacobian", "robot/robot_model", "scene/cup", "scene/hand_body",
    "scene/objects", "scene/physics", "scene/scene", "scene/water",
)  # fmt: skip
WITHOUT_HEADER = ("bus/endpoint", "scene/grip", "scene/particle_contacts", "scene/support")  # of theirs

# ODE itself, for what the product has no call for: forces and energies of bodies that tests hold against it.
ODE = """
struct dxBody; struct dxWorld; struct dxJointGroup;
const double *dBodyGetPosition(struct dxBody *);
const double *dBodyGetRotation(struct dxBody *);
const double *dBodyGetLinearVel(struct dxBody *);
const double *dBodyGetAngularVel(struct dxBody *);
void dBodySetLinearVel(struct dxBody *, double, double, double);
void dBodySetAngularVel(struct dxBody *, double, double, double);
void dBodyAddForce(struct dxBody *, double, double, double);
void dBodyAddTorque(struct dxBody *, double, double, double);
struct dxWorld *dBodyGetWorld(struct dxBody *);
void dWorldSetGravity(struct dxWorld *, double, double, double);
typedef void dMessageFunction(int number, const char *text, void *arguments);
void dSetMessageHandler(dMessageFunction *);
"""


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    """Compiled anew in each test run: a few seconds, and never stale."""
    BUILD.mkdir(parents=True, exist_ok=True)
    sources = [str(REPOSITORY / "sim" / f"{part}.c") for part in (*PARTS, *WITHOUT_HEADER)]
    sources += sorted(str(file) for file in FIRMWARE if file.name != "main.c")
    ffi = cffi.FFI()
    with tempfile.TemporaryDirectory(dir=BUILD) as name:
        folder = Path(name)
        ffi.cdef(declarations(REPOSITORY / "sim" / f"{part}.h" for part in PARTS) + ODE)
        library = folder / "plant.so"
        command = [*COMPILE, "-shared", *sources, "-lode", "-lm", "-o", str(library)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}\n{done.stderr}")
        return ffi, ffi.dlopen(str(library))
