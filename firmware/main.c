/* The firmware's loop: the same file on the host and on every target. */
#include "main.h"

#include <stddef.h>

#include "../hal/hal.h"
#include "arms/hoap3_right.h"
#include "controller.h"

void firmware_main(void) {
    static controller_t controller;
    static controller_inbox_t inbox;
    static controller_outbox_t outbox;

    hal_init();
    const char *defect = arm_check(&arm_hoap3_right);
    if (defect != NULL) {
        hal_panic(defect);
    }
    controller_init(&controller, &arm_hoap3_right, hal_can_profile());

    uint32_t now_us = 0;
    for (uint32_t tick_ms = 0; hal_wait_tick(&now_us); tick_ms++) {
        hal_watchdog_feed();
        if (tick_ms % controller.tick_ms != 0u) {
            continue; /* classic CAN carries a command each 4 ms */
        }
        inbox.count = 0;
        while (inbox.count < CONTROLLER_INBOX_FRAMES && hal_can_receive(&inbox.frame[inbox.count])) {
            inbox.count++;
        }
        controller_step(&controller, now_us, &inbox, &outbox);
        for (uint8_t i = 0; i < outbox.count; i++) {
            (void)hal_can_send(&outbox.frame[i]); /* a full queue is the port's to count: the drives' own timeout acts */
        }
    }
}
