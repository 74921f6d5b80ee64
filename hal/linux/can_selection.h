/* Selection of the frames of a bus. */
#ifndef COMANIP_CAN_SELECTION_H
#define COMANIP_CAN_SELECTION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Frames that a socket receives. */
typedef struct {
    const uint16_t *ids; /* the kernel filters; a hub sends all frames, and the reader ignores the others */
    size_t count;        /* 0: all */
    bool classic;        /* an interface without CAN FD is sufficient */
    bool own;            /* also the socket's own frames, in the bus's order; from the kernel only */
} can_selection_t;

#endif
