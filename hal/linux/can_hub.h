/* Connects to the hub, for machines without CAN in the kernel. hub_path.h defines where the hub is found. Each packet,
 * in either direction, is one struct can_frame or struct canfd_frame; no client receives its own frames back. */
#ifndef COMANIP_CAN_HUB_H
#define COMANIP_CAN_HUB_H

#include <stddef.h>

#include "hub_path.h"

/* Fills in the path, connects and returns the socket. On failure, returns -1 and one line in `error`. */
int can_hub_open(const char *name, char path[HUB_PATH_BYTES], char error[], size_t error_size);

/* Returns a connected, non-blocking socket; -1 on failure, with errno. */
int can_hub_connect(const char *path);

#endif
