/* The firmware's main loop, which is the same on the host and on every target. */
#include "main.h"

#include <stddef.h>

#include "../hal/hal.h"
#include "control/arms/hoap3_right_ik.h"
#include "controller.h"
#include "parameters/parameter_store.h"

/* Stored parameters are applied either all together or not at all. */
static void load_parameters(controller_t *controller) {
    uint8_t record[PARAMETER_STORE_MAX_BYTES + 1]; /* one byte more, to detect an oversized record */
    size_t length;
    if (hal_store_read(record, sizeof record, &length)) {
        parameters_t parameters = controller->parameters;
        bool valid = parameter_store_decode(record, length, &parameters);
        controller_set_parameters(controller, &parameters, valid ? RESULT_ACCEPTED : RESULT_STORE_FAILED);
    }
}

static void begin_save(const controller_t *controller) {
    uint8_t record[PARAMETER_STORE_BYTES];
    hal_store_write(record, parameter_store_encode(&controller->parameters, record));
}

static void report_save(controller_inbox_t *inbox) {
    static const result_t result[] = {
        [HAL_STORE_NONE] = RESULT_NOT_SUPPORTED,
        [HAL_STORE_WRITTEN] = RESULT_ACCEPTED,
        [HAL_STORE_FAILED] = RESULT_STORE_FAILED,
    };
    hal_store_status_t status = hal_store_status();
    inbox->save_over = status != HAL_STORE_WRITING;
    inbox->save_result = inbox->save_over ? result[status] : RESULT_ACCEPTED;
}

/* The result is ignored, because the port counts the frames that it refuses. If commands are lost, the drives' timeout
 * stops the arm. */
static void send_frame(void *context, const can_frame_t *frame) {
    (void)context;
    (void)hal_can_send(frame);
}

void firmware_main(void) {
    static controller_t controller;
    static controller_inbox_t inbox;
    controller_outbox_t outbox = {.sink = {.send = send_frame}};

    hal_init();
    const char *defect = arm_ik_check(&arm_ik_hoap3_right);
    if (defect != NULL) {
        hal_panic(defect);
    }
    controller_init(&controller, &arm_ik_hoap3_right, hal_can_profile());
    load_parameters(&controller);

    uint32_t now_us = 0;
    for (uint32_t tick_ms = 0; hal_wait_tick(&now_us); tick_ms++) {
        hal_watchdog_feed();
        while (inbox.count < CONTROLLER_INBOX_FRAMES && hal_can_receive(&inbox.frame[inbox.count])) {
            inbox.count++;
        }
        if (tick_ms % controller.tick_ms != 0u) {
            continue; /* on classic CAN the controller runs every 4 ms */
        }
        report_save(&inbox);
        hal_port_status(&inbox.port);
        controller_step(&controller, now_us, &inbox, &outbox);
        hal_enable_drives(outbox.enable_drives);
        inbox.count = 0;
        if (outbox.save) {
            begin_save(&controller);
        }
    }
    hal_enable_drives(false);
}
