/* The hub for machines without CAN in the kernel, found as hub_path.h says. Each packet, both ways, is one struct
 * can_frame or struct canfd_frame; no client gets its own frames back. */
#ifndef COMANIP_CAN_HUB_H
#define COMANIP_CAN_HUB_H

#include <stddef.h>

#include "hub_path.h"

/* Fills in the path and connects. On failure -1, and one line in `error`. */
int can_hub_open(const char *name, char path[HUB_PATH_BYTES], char error[], size_t error_size);

/* Connects, non-blocking. -1 on failure, with errno. */
int can_hub_connect(const char *path);

#endif
