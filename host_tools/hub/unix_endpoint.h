/* Clients of the Unix socket: each packet, both ways, is one struct can_frame or struct canfd_frame. One that shuts
 * down its receiving side (SHUT_RD) only sends. */
#ifndef COMANIP_HUB_UNIX_ENDPOINT_H
#define COMANIP_HUB_UNIX_ENDPOINT_H

#include "hub.h"

extern const endpoint_t unix_endpoint;

/* A listening socket at the path, for its owner only; what was there is replaced. On failure -1, and one line in
 * `error`. */
int unix_endpoint_open(const char *path, char error[], size_t error_size);

#endif
