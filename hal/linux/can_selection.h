/* Selects the frames of a bus to receive. */
#ifndef COMANIP_CAN_SELECTION_H
#define COMANIP_CAN_SELECTION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The frames that a socket receives. */
typedef struct {
    const uint16_t *ids; /* the kernel filters by these ids; a hub does not filter: the caller must ignore other ids */
    size_t count;        /* 0: all */
    bool classic;        /* an interface without CAN FD is sufficient */
    bool own;            /* also receive the socket's own frames, in bus order; supported by the kernel only */
} can_selection_t;

#endif
