/* Runs an image in lockstep with a simulator at the other end of its serial line. The simulator starts each tick, and
 * sends the tick's time and the time of reception of each frame. The image reports when it has sent all frames of a
 * tick. The results therefore depend neither on the speed of the line nor on that of the emulator. In addition to the
 * frames of the bus, the line carries five kinds of lockstep frames, with ids that no node uses. In the image,
 * lockstep.c replaces hal/common/tick.c and hal/slcan/slcan_receive.c. */
#ifndef COMANIP_LOCKSTEP_H
#define COMANIP_LOCKSTEP_H

#include "../../firmware/protocol/can_frame.h"

/* Ids of the lockstep frames. Each frame carries a number. */
#define LOCKSTEP_STAMP_ID 0x7F0u   /* from the simulator: time of reception of the next frame [us] */
#define LOCKSTEP_TICK_ID 0x7F1u    /* from the simulator: a tick starts at this time [us] */
#define LOCKSTEP_DONE_ID 0x7F2u    /* from the image: the tick is done, with the drives' enable line (1 on, 0 off) */
#define LOCKSTEP_REFUSED_ID 0x7F3u /* from the simulator: how many of the image's frames the bus has refused so far */
#define LOCKSTEP_LOST_ID 0x7F4u    /* from the simulator: how many frames to the image have been lost so far */

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
