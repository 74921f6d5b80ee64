/* Clients that speak socketcand over TCP, on the loopback interface only: python-can, SavvyCAN, cantools monitor. */
#ifndef COMANIP_HUB_SOCKETCAND_ENDPOINT_H
#define COMANIP_HUB_SOCKETCAND_ENDPOINT_H

#include "hub.h"

#define SOCKETCAND_DEFAULT_PORT 29536

extern const endpoint_t socketcand_endpoint;

/* Opens a listening socket at 127.0.0.1. port: 0 for any free port. Returns the socket, or -1 with errno. */
int socketcand_endpoint_open(int port);

/* Returns the port of the listening socket, or -1 with errno. */
int socketcand_endpoint_port(int listen_fd);

#endif
