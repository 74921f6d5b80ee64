/* Helpers for hal_port_status(), in which a port fills in the message PortStatus. */
#ifndef COMANIP_PORT_STATUS_H
#define COMANIP_PORT_STATUS_H

#include "messages.h"

/* Value of a count that the port cannot know. A count of 0, in contrast, means that the event has not occurred. */
#define PORT_UNKNOWN UINT16_MAX

/* A port starts with this value and fills in the counts that it knows. */
#define PORT_STATUS_UNKNOWN                                                                                            \
    {.can_state = PORT_CAN_UNKNOWN,                                                                                    \
     .refused_frames = PORT_UNKNOWN,                                                                                   \
     .lost_frames = PORT_UNKNOWN,                                                                                      \
     .error_passive = PORT_UNKNOWN,                                                                                    \
     .bus_off = PORT_UNKNOWN,                                                                                          \
     .missed_ticks = PORT_UNKNOWN,                                                                                     \
     .longest_tick_us = PORT_UNKNOWN}

/* Returns a known count, saturated at 65,534. */
static inline uint16_t port_count(uint64_t count) {
    return count < PORT_UNKNOWN ? (uint16_t)count : PORT_UNKNOWN - 1u;
}

#endif
