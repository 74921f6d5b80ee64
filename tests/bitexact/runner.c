/* Feeds a recorded input into controller_step() and writes a hash of what it sends, tick by tick: the same file on the host and,
 * in the place of firmware/main.c, on a target. Input and output: bitexact.py. */
#include "../../firmware/arms/hoap3_right.h"
#include "../../firmware/controller.h"
#include "../../firmware/main.h"
#include "platform.h"

typedef enum { RECORD_TICK = 0, RECORD_BOOT_FD = 1, RECORD_BOOT_CLASSIC = 2 } record_kind_t;

/* FNV-1a, 32 bits. */
static uint32_t add(uint32_t hash, const uint8_t bytes[], size_t count) {
    for (size_t i = 0; i < count; i++) {
        hash = (hash ^ bytes[i]) * 16777619u;
    }
    return hash;
}

static uint32_t hash_of(const controller_outbox_t *outbox) {
    uint32_t hash = 2166136261u;
    for (uint8_t i = 0; i < outbox->count; i++) {
        const can_frame_t *frame = &outbox->frame[i];
        const uint8_t head[3] = {(uint8_t)frame->id, (uint8_t)(frame->id >> 8), frame->length};
        hash = add(add(hash, head, sizeof head), frame->data, frame->length);
    }
    return hash;
}

static uint32_t word(const uint8_t bytes[4]) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

static bool read_frame(can_frame_t *frame) {
    uint8_t head[8]; /* stamp, id, length, FD */
    if (!platform_read(head, sizeof head)) {
        return false;
    }
    *frame = (can_frame_t){.timestamp_us = word(head), .id = (uint16_t)(head[4] | head[5] << 8), .length = head[6],
                           .fd = head[7] != 0};
    return platform_read(frame->data, frame->length);
}

void firmware_main(void) {
    static controller_t controller;
    static controller_inbox_t inbox;
    static controller_outbox_t outbox;
    uint8_t head[6]; /* time of the tick, kind, number of frames */
    platform_open();
    while (platform_read(head, sizeof head)) {
        if (head[4] != RECORD_TICK) {
            controller_init(&controller, &arm_hoap3_right,
                            head[4] == RECORD_BOOT_FD ? CAN_PROFILE_FD : CAN_PROFILE_CLASSIC);
            continue;
        }
        for (inbox.count = 0; inbox.count < head[5] && read_frame(&inbox.frame[inbox.count]); inbox.count++) {
        }
        controller_step(&controller, word(head), &inbox, &outbox);
        const uint32_t hash = hash_of(&outbox);
        const uint8_t bytes[4] = {(uint8_t)hash, (uint8_t)(hash >> 8), (uint8_t)(hash >> 16), (uint8_t)(hash >> 24)};
        platform_write(bytes, sizeof bytes);
    }
    platform_close();
}
