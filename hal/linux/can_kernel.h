/* Opens a raw socket of the kernel's SocketCAN on one interface. */
#ifndef COMANIP_CAN_KERNEL_H
#define COMANIP_CAN_KERNEL_H

#include <linux/can.h>
#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

#include "can_selection.h"

/* Returns whether the kernel supports CAN and has this interface. */
bool can_kernel_has(const char *name);

/* Returns a non-blocking socket. On failure, returns -1 and one line in `error`. */
int can_kernel_open(const char *name, const can_selection_t *selection, char error[], size_t error_size);

/* Metadata of a packet from the kernel. */
typedef struct {
    int64_t unix_ns, hardware_ns; /* as in can_reception_t of can_socket.h; 0: no timestamp */
    bool own;
    bool has_drops;
    uint32_t drops; /* frames dropped by this socket since it was opened, modulo 2^32 */
} can_kernel_notes_t;

/* Receives one packet with recvmsg(); also works for a hub's socket. Returns 0 at the end of the stream, and -1 with
 * errno on failure. */
ssize_t can_kernel_receive(int fd, struct canfd_frame *packet, can_kernel_notes_t *notes);

#endif
