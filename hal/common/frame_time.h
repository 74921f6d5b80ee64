/* Computes how long a frame occupies the bus, according to ISO 11898-1, for an 11-bit id and a nominal bit rate of 1
 * Mbit/s; the data phase of CAN FD runs at 5 Mbit/s. */
#ifndef COMANIP_FRAME_TIME_H
#define COMANIP_FRAME_TIME_H

#include <stdint.h>

#include "../../firmware/protocol/can_frame.h"

/* Returns the time from SOF to the end of the intermission, including the stuff bits for this id and data. Returns a
 * negative value if there is no such frame, that is, if the id has more than 11 bits or no DLC corresponds to the
 * length. */
int64_t frame_time_ns(const can_frame_t *frame);

#endif
