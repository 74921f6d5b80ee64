/* The firmware as an image at the other end of a serial line, in lockstep with the world: hal/lockstep/lockstep.h. */
#ifndef COMANIP_SIM_REMOTE_FIRMWARE_H
#define COMANIP_SIM_REMOTE_FIRMWARE_H

#include "../world/world.h"

/* path: a Unix socket, as QEMU's -serial unix:PATH. False, and one line in `error`, if there is none. */
bool remote_firmware_open(const char *path, char error[], size_t error_size);

/* To the end of the run. An image that panics or does not answer for a minute ends it as a failure, with its words. */
void remote_firmware_run(world_t *world);

#endif
