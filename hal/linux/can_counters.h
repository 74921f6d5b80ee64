/* Traffic and faults of a bus since it was opened. */
#ifndef COMANIP_CAN_COUNTERS_H
#define COMANIP_CAN_COUNTERS_H

#include <stdint.h>

#include "../../firmware/protocol/port_status.h"

typedef struct {
    uint64_t received, sent;
    uint64_t send_drops;    /* frames that found the transmit queue full or the bus gone */
    uint64_t receive_drops; /* frames that found the socket's or the controller's receive queue full */
    uint64_t ignored;       /* remote frames, 29-bit ids, malformed packets */
    uint64_t error_frames;  /* CAN error frames, of which: */
    uint64_t error_passive, bus_offs, restarts;
    port_can_state_t can_state; /* by the last error frame that reports one; unknown before */
    uint64_t losses;            /* times that the bus was lost: interface down, hub gone */
} can_counters_t;

#endif
