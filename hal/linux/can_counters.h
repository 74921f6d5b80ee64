/* Counts of the traffic and the faults of a bus since it was opened. */
#ifndef COMANIP_CAN_COUNTERS_H
#define COMANIP_CAN_COUNTERS_H

#include <stdint.h>

#include "../../firmware/protocol/port_status.h"

typedef struct {
    uint64_t received, sent;
    uint64_t send_drops;    /* frames not sent, because the transmit queue was full or the bus was gone */
    uint64_t receive_drops; /* frames lost, because the receive queue of the socket or of the controller was full */
    uint64_t ignored;       /* remote frames, 29-bit ids, malformed packets */
    uint64_t error_frames;  /* CAN error frames; the next three count some of their kinds */
    uint64_t error_passive, bus_offs, restarts;
    port_can_state_t can_state; /* state in the last error frame that reports one; unknown before */
    uint64_t losses;            /* number of times that the bus was lost: interface down or hub gone */
} can_counters_t;

#endif
