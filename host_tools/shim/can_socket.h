/* Emulated raw CAN sockets. Each consists of a connection to a hub and the state that SocketCAN keeps for a socket. */
#ifndef COMANIP_SHIM_CAN_SOCKET_H
#define COMANIP_SHIM_CAN_SOCKET_H

#include <stdbool.h>
#include <sys/socket.h>
#include <sys/types.h>

#include "receive_filter.h"

typedef struct {
    int fd;
    dev_t device; /* device and inode identify the socket, to check that the descriptor still refers to it */
    ino_t inode;
    unsigned index; /* index of the interface to which the socket is connected, 0 if there is none */
    bool is_bound;
    bool loopback; /* other sockets on this machine receive the frames that this socket sends */
    bool receives_own;
    receive_filter_t filter;
    int sender; /* second connection, for sending to another interface or for receiving own frames; -1: none */
    unsigned sender_index;
} can_socket_t;

/* Turns the descriptor of a new AF_UNIX socket into an emulated CAN socket. Returns the descriptor, or -1 with errno.
 */
int can_socket_adopt(int fd);

/* Returns the CAN socket of a descriptor, or NULL. Does not change errno. */
can_socket_t *can_socket_find(int fd);

void can_socket_forget(can_socket_t *self);

/* Connects the socket to the hub of the interface. index: 0 for any interface. This is possible if exactly one hub
 * exists, or if the socket's filter passes no frames, so that the socket only sends. Returns 0, or -1 with errno. */
int can_socket_bind(can_socket_t *self, unsigned index);

/* Returns the descriptor through which a frame must be sent to the interface, or -1 with errno. index: 0 for the
 * interface to which the socket is bound. */
int can_socket_route(can_socket_t *self, unsigned index);

/* Set or get an option of SOL_CAN_RAW. Return 0, or -1 with errno. */
int can_socket_set_option(can_socket_t *self, int name, const void *value, socklen_t length);
int can_socket_get_option(const can_socket_t *self, int name, void *value, socklen_t *length);

#endif
