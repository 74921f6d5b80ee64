/* An image in lockstep with a simulator at the other end of its serial line: the simulator says when a tick is, with
 * what time, and when each frame was received; the image says when it has sent all of a tick. So neither the line's
 * speed nor the emulator's has a part in what is computed. Beside the frames of the bus three of their own go over the
 * line, with ids that no node has. lockstep.c stands in the image in place of hal/common/tick.c and
 * hal/slcan/slcan_receive.c. */
#ifndef COMANIP_LOCKSTEP_H
#define COMANIP_LOCKSTEP_H

#include "../../firmware/protocol/can_frame.h"

#define LOCKSTEP_STAMP_ID 0x7F0u /* simulator: time of reception of the next frame */
#define LOCKSTEP_TICK_ID 0x7F1u  /* simulator: a tick begins, at this time */
#define LOCKSTEP_DONE_ID                                                                                               \
    0x7F2u /* image: it waits for the next tick; in the time's place 1: its drives' enable line is on */

/* A frame that carries a time. */
static inline can_frame_t lockstep_frame(uint16_t id, uint32_t time_us) {
    return (can_frame_t){
        .id = id,
        .length = 4,
        .data = {(uint8_t)time_us, (uint8_t)(time_us >> 8), (uint8_t)(time_us >> 16), (uint8_t)(time_us >> 24)}};
}

static inline uint32_t lockstep_time_us(const can_frame_t *frame) {
    return (uint32_t)frame->data[0] | (uint32_t)frame->data[1] << 8 | (uint32_t)frame->data[2] << 16 |
           (uint32_t)frame->data[3] << 24;
}

#endif
