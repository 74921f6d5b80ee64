/* Emulated raw CAN sockets. Each is a connection to a hub, together with the state that SocketCAN keeps for a socket.
 * */
#ifndef COMANIP_SHIM_CAN_SOCKET_H
#define COMANIP_SHIM_CAN_SOCKET_H

#include <stdbool.h>
#include <sys/socket.h>
#include <sys/types.h>

#include "receive_filter.h"

typedef struct {
    int fd;
    dev_t device; /* with inode: to check that the descriptor is still this socket */
    ino_t inode;
    unsigned index; /* of the interface that it is connected to; 0: none */
    bool is_bound;
    bool loopback; /* other sockets on this machine receive what this one sends */
    bool receives_own;
    receive_filter_t filter;
    int sender; /* a second connection, for frames that this socket receives itself or for another interface; or -1 */
    unsigned sender_index;
} can_socket_t;

/* Turns the descriptor of a new AF_UNIX socket into an emulated CAN socket. Returns it, or -1 with errno. */
int can_socket_adopt(int fd);

/* The CAN socket of a descriptor, or NULL. Does not change errno. */
can_socket_t *can_socket_find(int fd);

void can_socket_forget(can_socket_t *self);

/* Connects to the hub of the interface; index 0: to the only hub. Returns 0, or -1 with errno. */
int can_socket_bind(can_socket_t *self, unsigned index);

/* The descriptor through which to send a frame to the interface (0: the one that the socket is bound to), or -1 with
 * errno. */
int can_socket_route(can_socket_t *self, unsigned index);

/* Options of SOL_CAN_RAW. Return 0, or -1 with errno. */
int can_socket_set_option(can_socket_t *self, int name, const void *value, socklen_t length);
int can_socket_get_option(const can_socket_t *self, int name, void *value, socklen_t *length);

#endif
