/* The host port: the firmware's platform is the simulated world, in lockstep and virtual time. */
#ifndef COMANIP_HAL_HOST_H
#define COMANIP_HAL_HOST_H

#include "../../sim/world.h"

/* Runs the firmware in this world until the run is over or the firmware panics, which then is the world's failure. */
void hal_host_run(world_t *world);

#endif
