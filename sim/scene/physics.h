/* ODE's set-up, common to all rigid bodies of the scene. */
#ifndef COMANIP_SIM_PHYSICS_H
#define COMANIP_SIM_PHYSICS_H

#define PHYSICS_GRAVITY_MPS2 9.80665
/* Share of a joint's drift that ODE takes back per step: with 1 ms steps the joints' gaps stay below 1 um. */
#define PHYSICS_ERROR_REDUCTION 0.8

struct dxWorld;

/* With gravity along -z; a pair of calls of ODE's own initialisation goes with it. */
struct dxWorld *physics_create(void);
void physics_destroy(struct dxWorld *world);

/* Exact solver. */
void physics_step(struct dxWorld *world, double step_s);

#endif
