/* Receives frames from the serial line, and reports lost and refused frames. In an image that runs in lockstep with a
 * simulator, hal/lockstep/ replaces this file. */
#include "../common/tick.h"
#include "../hal.h"
#include "slcan_hal.h"

bool hal_can_receive(can_frame_t *frame) {
    return slcan_link_receive(&slcan_hal_link, frame);
}

void hal_port_status(port_status_t *status) {
    const slcan_link_counters_t *counters = &slcan_hal_link.counters;
    *status = (port_status_t)PORT_STATUS_UNKNOWN;
    status->refused_frames = port_count(counters->tx_dropped);
    /* rx_overrun is not added, because a line in which the UART lost bytes is already counted as malformed. */
    status->lost_frames = port_count((uint64_t)counters->rx_overflow + counters->rx_malformed);
    tick_status(status);
}
