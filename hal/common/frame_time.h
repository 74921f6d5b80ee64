/* How long a frame occupies the bus: ISO 11898-1, 11-bit id, 1 Mbit/s nominal; the data
 * phase of CAN FD 5 Mbit/s. */
#ifndef COMANIP_FRAME_TIME_H
#define COMANIP_FRAME_TIME_H

#include <stdint.h>

#include "../../firmware/protocol/can_frame.h"

/* From SOF to the end of the intermission, including the stuff bits of this id and data. Negative: there is no such
 * frame, since the id has more than 11 bits or no DLC corresponds to the length. */
int64_t frame_time_ns(const can_frame_t *frame);

#endif
