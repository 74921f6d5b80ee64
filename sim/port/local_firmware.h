/* Runs the firmware in this process. This port implements the HAL (hal/hal.h) on the simulated world, which advances in
 * lockstep with the firmware and in virtual time. */
#ifndef COMANIP_SIM_LOCAL_FIRMWARE_H
#define COMANIP_SIM_LOCAL_FIRMWARE_H

#include "../world/world.h"

/* Runs the firmware in this world until the run is over or the firmware panics, which fails the run. */
void local_firmware_run(world_t *world);

#endif
