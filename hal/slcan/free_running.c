/* The firmware's ticks by the board's own timer. */
#include "../hal.h"
#include "slcan_hal.h"

bool hal_wait_tick(uint32_t *now_us) {
    *now_us = clock_wait_tick();
    return true;
}

bool hal_can_receive(can_frame_t *frame) {
    return slcan_link_receive(&slcan_hal_link, frame);
}
