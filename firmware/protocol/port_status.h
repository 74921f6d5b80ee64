/* For hal_port_status(), in which a port fills in the message PortStatus. */
#ifndef COMANIP_PORT_STATUS_H
#define COMANIP_PORT_STATUS_H

#include "messages.h"

/* Stands for a count that the port cannot have. 0: it has not happened. */
#define PORT_UNKNOWN UINT16_MAX

/* A port starts with this and fills in the counts that it has. */
#define PORT_STATUS_UNKNOWN                                                                                            \
    {.can_state = PORT_CAN_UNKNOWN,                                                                                    \
     .refused_frames = PORT_UNKNOWN,                                                                                   \
     .lost_frames = PORT_UNKNOWN,                                                                                      \
     .error_passive = PORT_UNKNOWN,                                                                                    \
     .bus_off = PORT_UNKNOWN,                                                                                          \
     .missed_ticks = PORT_UNKNOWN,                                                                                     \
     .longest_tick_us = PORT_UNKNOWN}

/* A known count: 65,534 means as many or more. */
static inline uint16_t port_count(uint64_t count) {
    return count < PORT_UNKNOWN ? (uint16_t)count : PORT_UNKNOWN - 1u;
}

#endif
