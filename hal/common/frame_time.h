/* How long a frame occupies the bus: ISO 11898-1, 11-bit id, 1 Mbit/s nominal; CAN FD with 5 Mbit/s in the data phase.
 */
#ifndef COMANIP_FRAME_TIME_H
#define COMANIP_FRAME_TIME_H

#include <stdint.h>

#include "../../firmware/protocol/can_frame.h"

/* From SOF to the end of the intermission, with the stuff bits that this very id and data cause.
 * Negative: no such frame, for the id has more than 11 bits or no DLC stands for the length. */
int64_t frame_time_ns(const can_frame_t *frame);

#endif
