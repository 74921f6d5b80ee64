/* Sockets that the program takes for raw CAN sockets: each is a connection to a hub, and what SocketCAN knows of it. */
#ifndef COMANIP_SHIM_CAN_SOCKET_H
#define COMANIP_SHIM_CAN_SOCKET_H

#include <stdbool.h>
#include <sys/socket.h>
#include <sys/types.h>

#include "receive_filter.h"

typedef struct {
    int fd;
    dev_t device; /* with inode: to see that the descriptor is still this socket */
    ino_t inode;
    unsigned index; /* of the interface it is connected to; 0: none */
    bool is_bound;
    bool loopback; /* others on this machine see what is sent */
    bool receives_own;
    receive_filter_t wanted;
    int sender; /* a second connection, for frames that this socket shall get back, or to another interface; -1 */
    unsigned sender_index;
} can_socket_t;

/* Makes the descriptor of a new AF_UNIX socket one. Gives it, or -1 with errno. */
int can_socket_adopt(int fd);

/* NULL if the descriptor is none. Leaves errno alone. */
can_socket_t *can_socket_find(int fd);

void can_socket_forget(can_socket_t *self);

/* Connects to the hub of the interface; index 0: of the only one. Gives 0, or -1 with errno. */
int can_socket_bind(can_socket_t *self, unsigned index);

/* The descriptor on which a frame for the interface goes (0: the one it is bound to), or -1 with errno. */
int can_socket_route(can_socket_t *self, unsigned index);

/* Of SOL_CAN_RAW. Gives 0, or -1 with errno. */
int can_socket_set_option(can_socket_t *self, int name, const void *value, socklen_t length);
int can_socket_get_option(const can_socket_t *self, int name, void *value, socklen_t *length);

#endif
