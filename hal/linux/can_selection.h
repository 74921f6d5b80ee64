/* Which frames of a bus are wanted. */
#ifndef COMANIP_CAN_SELECTION_H
#define COMANIP_CAN_SELECTION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Whose frames the socket gets. */
typedef struct {
    const uint16_t *ids; /* the kernel filters these out of the bus; a hub sends all, and the rest is dropped here */
    size_t count;        /* 0: all */
    bool classic;        /* an interface without CAN FD will do */
    bool own;            /* the socket's own frames, too, in the bus's order: the kernel only, a hub sends none back */
} can_selection_t;

#endif
