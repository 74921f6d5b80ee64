"""The simulated arm in its physical scene, its drives and the monitors as a Python library: ``ffi, lib = load()``.
Needs ODE."""

from __future__ import annotations

import functools

import c_library
import cffi
from c_declarations import declarations
from c_library import CORE, REPOSITORY

PARTS = (
    "bus/bus", "bus/frame_time", "common/events", "common/names", "common/rigid_pose", "common/solve_3x3", "monitors/limit_monitor",
    "monitors/reach", "nodes/drive_node", "robot/arm_plant", "robot/position_jacobian", "robot/robot_model", "scene/cup", "scene/hand_body",
    "scene/objects", "scene/physics", "scene/scene", "scene/water",
)  # fmt: skip
WITHOUT_HEADER = (
    "bus/endpoint", "scene/grip", "scene/particle_contacts", "scene/particle_solver", "scene/support",
)  # fmt: skip

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
    headers = [REPOSITORY / "sim" / f"{part}.h" for part in PARTS]
    sources = [REPOSITORY / "sim" / f"{part}.c" for part in (*PARTS, *WITHOUT_HEADER)]
    return c_library.load("plant", declarations(headers) + ODE, sources + CORE, libraries=["ode"])
