/* Runs the firmware in this process: the host port, whose platform is the simulated world, in lockstep and virtual
 * time. */
#ifndef COMANIP_SIM_LOCAL_FIRMWARE_H
#define COMANIP_SIM_LOCAL_FIRMWARE_H

#include "../world/world.h"

/* Runs the firmware in this world until the run is over or the firmware panics, which fails the run. */
void local_firmware_run(world_t *world);

#endif
