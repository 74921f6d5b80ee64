"""Builds the simulated arm with its drives in its physical scene, with ODE: ``ffi, lib = load()``."""

from __future__ import annotations

import functools

import cffi
import simulator_library

MODULES = (
    "sim/bus/bus", "sim/common/events", "sim/common/names", "sim/monitors/limit_monitor", "sim/monitors/reach",
    "sim/nodes/drive_node", "sim/robot/position_jacobian", "sim/robot/robot_model", "sim/scene/arm_plant",
    "sim/scene/cup", "sim/scene/hand_body", "sim/scene/objects", "sim/scene/physics", "sim/scene/scene",
    "sim/scene/water",
)  # fmt: skip

# ODE functions with which tests read and change the state of bodies. The product has no functions for this.
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
    return simulator_library.load(MODULES, libraries=["ode"], declared=ODE)
