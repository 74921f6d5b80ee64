#include "can_errors.h"

#include <linux/can/error.h>
#include <stdbool.h>
#include <stdio.h>

static void report(const char *program, const char *bus, const char *what) {
    (void)fprintf(stderr, "%s: %s: %s\n", program, bus, what);
}

void can_errors_report(const char *program, const char *bus, const struct canfd_frame *error,
                       can_counters_t *counters) {
    const uint8_t controller = error->data[1];
    const bool is_controller = (error->can_id & CAN_ERR_CRTL) != 0;
    counters->error_frames++;
    if ((error->can_id & CAN_ERR_BUSOFF) != 0) {
        counters->bus_offs++;
        counters->can_state = PORT_CAN_BUS_OFF;
        report(program, bus,
               "bus-off: the controller sends nothing until it is restarted (ip link set NAME type can restart)");
    }
    if ((error->can_id & CAN_ERR_RESTARTED) != 0) {
        counters->restarts++;
        counters->can_state = PORT_CAN_ERROR_ACTIVE;
        report(program, bus, "the controller was restarted");
    }
    if (is_controller && (controller & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) {
        counters->error_passive++;
        counters->can_state = PORT_CAN_ERROR_PASSIVE;
        report(program, bus,
               "error-passive: frames are not acknowledged or are disturbed (check wiring, termination, bit rate)");
    }
    if (is_controller && (controller & CAN_ERR_CRTL_ACTIVE) != 0) {
        counters->can_state = PORT_CAN_ERROR_ACTIVE;
    }
    if (is_controller && (controller & (CAN_ERR_CRTL_RX_OVERFLOW | CAN_ERR_CRTL_TX_OVERFLOW)) != 0) {
        counters->receive_drops += (controller & CAN_ERR_CRTL_RX_OVERFLOW) != 0;
        counters->send_drops += (controller & CAN_ERR_CRTL_TX_OVERFLOW) != 0;
        report(program, bus, "the controller's queue overflowed: frames are lost");
    }
}
