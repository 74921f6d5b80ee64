/* Connects to the firmware in an image over a serial line, in lockstep with the world (hal/lockstep/lockstep.h). */
#ifndef COMANIP_SIM_REMOTE_FIRMWARE_H
#define COMANIP_SIM_REMOTE_FIRMWARE_H

#include "../world/world.h"

/* path: a Unix socket, as in QEMU's -serial unix:PATH. Returns false, with one line in `error`, if it cannot
 * connect. */
bool remote_firmware_open(const char *path, char error[], size_t error_size);

/* Runs the world to its end. A panic of the image, with its message, or no answer for a minute fails the run. */
void remote_firmware_run(world_t *world);

#endif
