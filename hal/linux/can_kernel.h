/* The kernel's SocketCAN: a raw socket on one interface. */
#ifndef COMANIP_CAN_KERNEL_H
#define COMANIP_CAN_KERNEL_H

#include <linux/can.h>
#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

#include "can_selection.h"

/* True: the kernel has CAN, and this interface. */
bool can_kernel_has(const char *name);

/* Gives the socket, non-blocking. On failure -1, and one line in `error`. */
int can_kernel_open(const char *name, const can_selection_t *selection, char error[], size_t error_size);

/* Metadata of a packet from the kernel. */
typedef struct {
    int64_t unix_ns, hardware_ns; /* as in can_reception_t of can_socket.h; 0: none */
    bool own;
    bool has_drops;
    uint32_t drops; /* of this socket since it was opened, modulo 2^32 */
} can_kernel_notes_t;

/* recvmsg() of one packet, from a hub's socket as well: 0 at its end, -1 with errno. */
ssize_t can_kernel_receive(int fd, struct canfd_frame *packet, can_kernel_notes_t *notes);

#endif
