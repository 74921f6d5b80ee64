/* Ticks and frames from a simulator: see lockstep.h. */
#include "lockstep.h"

#include "../hal.h"
#include "../slcan/slcan_hal.h"

#define QUEUE_FRAMES 32 /* more frames than the firmware receives in two ticks */

static struct {
    can_frame_t frame[QUEUE_FRAMES]; /* ring */
    uint8_t first, count;
    uint32_t stamp_us; /* time of reception of the next frame */
} received;

static uint32_t refused_frames, lost_frames; /* as last reported by the simulator */

static void keep(const can_frame_t *frame) {
    if (received.count == QUEUE_FRAMES) {
        hal_panic("lockstep: the queue of received frames is full");
    }
    can_frame_t *place = &received.frame[(received.first + received.count++) % QUEUE_FRAMES];
    *place = *frame;
    place->timestamp_us = received.stamp_us;
}

static void report_done(void) {
    const can_frame_t done = lockstep_frame(LOCKSTEP_DONE_ID, drives_enabled());
    while (!hal_can_send(&done)) {
        serial_wait(); /* wait until the line has sent the tick's frames */
        hal_watchdog_feed();
    }
}

bool hal_wait_tick(uint32_t *now_us) {
    report_done();
    for (;;) {
        can_frame_t frame;
        if (!slcan_link_receive(&slcan_hal_link, &frame)) {
            serial_wait();
            hal_watchdog_feed(); /* the simulator may take any length of time */
        } else if (frame.id == LOCKSTEP_STAMP_ID) {
            received.stamp_us = lockstep_number(&frame);
        } else if (frame.id == LOCKSTEP_TICK_ID) {
            *now_us = lockstep_number(&frame);
            return true;
        } else if (frame.id == LOCKSTEP_REFUSED_ID) {
            refused_frames = lockstep_number(&frame);
        } else if (frame.id == LOCKSTEP_LOST_ID) {
            lost_frames = lockstep_number(&frame);
        } else {
            keep(&frame);
        }
    }
}

bool hal_can_receive(can_frame_t *frame) {
    if (received.count == 0) {
        return false;
    }
    *frame = received.frame[received.first];
    received.first = (received.first + 1u) % QUEUE_FRAMES;
    received.count--;
    return true;
}

/* Reports the same values as the firmware in the simulator's process: see sim/port/local_firmware.c. */
void hal_port_status(port_status_t *status) {
    *status = (port_status_t)PORT_STATUS_UNKNOWN;
    status->refused_frames = port_count(refused_frames);
    status->lost_frames = port_count(lost_frames);
    status->missed_ticks = 0;
}
