/* An image in lockstep with a simulator at the other end of its serial line: the simulator says when a tick is, with
 * what time, and when each frame was received; the image says when it has sent all of a tick. So neither the line's
 * speed nor the emulator's has a part in what is computed. Beside the frames of the bus five of their own go over the
 * line, with ids that no node has. lockstep.c stands in the image in place of hal/common/tick.c and
 * hal/slcan/slcan_receive.c. */
#ifndef COMANIP_LOCKSTEP_H
#define COMANIP_LOCKSTEP_H

#include "../../firmware/protocol/can_frame.h"

/* Each carries a number. */
#define LOCKSTEP_STAMP_ID 0x7F0u   /* simulator: time of reception of the next frame [us] */
#define LOCKSTEP_TICK_ID 0x7F1u    /* simulator: a tick begins, at this time [us] */
#define LOCKSTEP_DONE_ID 0x7F2u    /* image: it waits for the next tick; 1: its drives' enable line is on, 0: off */
#define LOCKSTEP_REFUSED_ID 0x7F3u /* simulator: so many of the image's frames its bus has refused so far */
#define LOCKSTEP_LOST_ID 0x7F4u    /* simulator: so many frames for the image were lost so far */

static inline can_frame_t lockstep_frame(uint16_t id, uint32_t number) {
    return (can_frame_t){
        .id = id,
        .length = 4,
        .data = {(uint8_t)number, (uint8_t)(number >> 8), (uint8_t)(number >> 16), (uint8_t)(number >> 24)}};
}

static inline uint32_t lockstep_number(const can_frame_t *frame) {
    return (uint32_t)frame->data[0] | (uint32_t)frame->data[1] << 8 | (uint32_t)frame->data[2] << 16 |
           (uint32_t)frame->data[3] << 24;
}

#endif
