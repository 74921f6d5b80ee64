/* Clients of the Unix socket. Each packet, in either direction, is one struct can_frame or struct canfd_frame. A client
 * that shuts down its receiving side (SHUT_RD) only sends. */
#ifndef COMANIP_HUB_UNIX_ENDPOINT_H
#define COMANIP_HUB_UNIX_ENDPOINT_H

#include "hub.h"

extern const endpoint_t unix_endpoint;

/* Opens a listening socket at the path, accessible to its owner only, and replaces an existing one. Returns it, or -1
 * with one line in `error`. */
int unix_endpoint_open(const char *path, char error[], size_t error_size);

#endif
