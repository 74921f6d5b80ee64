/* Reception by the HAL as the frames come in; an image that a simulator steps has hal/lockstep in place of this. */
#include "../hal.h"
#include "slcan_hal.h"

bool hal_can_receive(can_frame_t *frame) {
    return slcan_link_receive(&slcan_hal_link, frame);
}
