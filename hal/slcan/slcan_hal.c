/* The HAL's CAN functions for ports that carry CAN over a UART. */
#include "slcan_hal.h"

#include "../hal.h"

slcan_link_t slcan_hal_link;

bool hal_can_send(const can_frame_t *frame) {
    bool queued = slcan_link_send(&slcan_hal_link, frame);
    if (queued) {
        serial_start_transmission();
    }
    return queued;
}

static void write_text(const char *text) {
    for (; *text != '\0'; text++) {
        serial_write_polled((uint8_t)*text);
    }
}

void slcan_hal_report_panic(const char *cause) {
    write_text("\r#panic: ");
    write_text(cause);
    write_text("\r");
}
