/* Selection of the frames of a bus. */
#ifndef COMANIP_CAN_SELECTION_H
#define COMANIP_CAN_SELECTION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Frames that a socket receives. */
typedef struct {
    const uint16_t *ids; /* filtered by the kernel; a hub sends all frames, and the others are dropped here */
    size_t count;        /* 0: all */
    bool classic;        /* an interface without CAN FD is sufficient */
    bool own;            /* also the socket's own frames, in the bus's order; from the kernel only */
} can_selection_t;

#endif
