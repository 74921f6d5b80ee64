/* Clients of the Unix socket. Each packet in either direction is a struct can_frame or a struct canfd_frame. No frames
 * are sent to a client that has shut down its receiving side (SHUT_RD). */
#ifndef COMANIP_HUB_UNIX_ENDPOINT_H
#define COMANIP_HUB_UNIX_ENDPOINT_H

#include "hub.h"

extern const endpoint_t unix_endpoint;

/* Opens a listening socket at the path and replaces an existing one. Only the owner can access the socket. Returns the
 * descriptor of the socket, or -1 with one line in `error`. */
int unix_endpoint_open(const char *path, char error[], size_t error_size);

#endif
