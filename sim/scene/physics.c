#include "physics.h"

#include <ode/ode.h>

dWorldID physics_create(void) {
    dInitODE2(0);
    dAllocateODEDataForThread((unsigned int)dAllocateMaskAll);
    const dWorldID world = dWorldCreate();
    dWorldSetGravity(world, 0.0, 0.0, -PHYSICS_GRAVITY_MPS2);
    dWorldSetERP(world, PHYSICS_ERROR_REDUCTION);
    return world;
}

void physics_destroy(dWorldID world) {
    dWorldDestroy(world);
    dCloseODE();
}

void physics_step(dWorldID world, double step_s) {
    dWorldStep(world, step_s);
}
