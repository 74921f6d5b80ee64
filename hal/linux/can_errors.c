#include "can_errors.h"

#include <linux/can/error.h>
#include <stdio.h>

static void tell(const can_socket_t *socket, const char *what) {
    (void)fprintf(stderr, "%s: %s: %s\n", socket->program, socket->name, what);
}

void can_errors_tell(can_socket_t *socket, const struct canfd_frame *error) {
    const uint8_t controller = error->data[1];
    const bool is_controller = (error->can_id & CAN_ERR_CRTL) != 0;
    socket->counters.error_frames++;
    if ((error->can_id & CAN_ERR_BUSOFF) != 0) {
        socket->counters.bus_offs++;
        tell(socket, "bus-off: the controller sends nothing until it is restarted (ip link set NAME type can restart)");
    }
    if ((error->can_id & CAN_ERR_RESTARTED) != 0) {
        socket->counters.restarts++;
        tell(socket, "the controller was restarted");
    }
    if (is_controller && (controller & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) {
        socket->counters.error_passive++;
        tell(socket, "error-passive: frames are not acknowledged or are disturbed (wiring, termination, bit rate)");
    }
    if (is_controller && (controller & (CAN_ERR_CRTL_RX_OVERFLOW | CAN_ERR_CRTL_TX_OVERFLOW)) != 0) {
        tell(socket, "the controller's queue ran over: frames are lost");
    }
}
