/* The Linux port: the firmware as a process on a real bus. */
#ifndef COMANIP_LINUX_PORT_H
#define COMANIP_LINUX_PORT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "../../firmware/protocol/can_profile.h"

/* Opens the bus and reads the store. Must be called before firmware_main(). parameters: the store's file, or NULL for
 * none. On failure, returns false and one line in `error`. */
bool port_open(const char *can, can_profile_t profile, uint32_t slow, const char *parameters, char error[],
               size_t error_size);

/* Closes the bus and reports on stdout how the run went. Must be called after firmware_main(). */
void port_close(void);

#endif
