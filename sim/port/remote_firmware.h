/* Connects over a serial line to an image of the firmware, which runs in an emulator or on a board, and keeps it in
 * lockstep with the world (hal/lockstep/lockstep.h). */
#ifndef COMANIP_SIM_REMOTE_FIRMWARE_H
#define COMANIP_SIM_REMOTE_FIRMWARE_H

#include "../world/world.h"

/* Connects to a Unix socket, such as that of QEMU's -serial unix:PATH. Returns false on failure, with one line in
 * `error`. */
bool remote_firmware_open(const char *path, char error[], size_t error_size);

/* Runs the world to its end. If the image panics, the run fails with the image's message. The run also fails if the
 * image does not answer for a minute. */
void remote_firmware_run(world_t *world);

#endif
