/* The records of input.bin, which stimulus.py and tests/cycles/cycles.py write. Each record is a header. In a record of
 * a tick, the frames that the firmware reads in this tick follow; in a record of a state, the state follows. */
#ifndef COMANIP_BITEXACT_RECORDS_H
#define COMANIP_BITEXACT_RECORDS_H

#include "../../firmware/control/arms/hoap3_right_ik.h"
#include "../../firmware/controller.h"
#include "platform.h"

typedef enum {
    RECORD_TICK = 0,
    RECORD_BOOT_FD = 1,
    RECORD_BOOT_CLASSIC = 2,
    RECORD_STATE = 3, /* for tests/cycles: joint positions and the hand's pose */
} record_kind_t;

typedef struct {
    uint32_t now_us;
    uint8_t kind;  /* record_kind_t */
    uint8_t count; /* number of frames; RECORD_STATE: the task */
} record_t;

static inline uint32_t record_word(const uint8_t bytes[4]) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

static inline bool record_read_frame(can_frame_t *frame) {
    uint8_t head[8]; /* timestamp (4 bytes), id (2 bytes), length, FD flag */
    if (!platform_read(head, sizeof head)) {
        return false;
    }
    *frame = (can_frame_t){.timestamp_us = record_word(head),
                           .id = (uint16_t)(head[4] | head[5] << 8),
                           .length = head[6],
                           .fd = head[7] != 0};
    return platform_read(frame->data, frame->length);
}

/* Reads the header of the next record. Returns false at the end of the input. */
static inline bool record_read(record_t *record) {
    uint8_t head[6];
    if (!platform_read(head, sizeof head)) {
        return false;
    }
    *record = (record_t){.now_us = record_word(head), .kind = head[4], .count = head[5]};
    return true;
}

static inline void record_boot(const record_t *record, controller_t *controller) {
    controller_init(controller, &arm_ik_hoap3_right,
                    record->kind == RECORD_BOOT_FD ? CAN_PROFILE_FD : CAN_PROFILE_CLASSIC);
}

static inline void record_read_inbox(const record_t *record, controller_inbox_t *inbox) {
    for (inbox->count = 0; inbox->count < record->count && record_read_frame(&inbox->frame[inbox->count]);
         inbox->count++) {
    }
}

#endif
