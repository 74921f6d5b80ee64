/* Feeds input.bin to controller_step(), tick by tick, and writes a hash of the frames sent in each tick to output.bin.
 * This file is built for the host and, in place of firmware/main.c, for each target. bitexact.py writes the input and
 * compares the outputs. */
#include "../../firmware/main.h"
#include "records.h"

/* Adds bytes to a 32-bit FNV-1a hash. */
static uint32_t add(uint32_t hash, const uint8_t bytes[], size_t count) {
    for (size_t i = 0; i < count; i++) {
        hash = (hash ^ bytes[i]) * 16777619u;
    }
    return hash;
}

static void add_frame(void *context, const can_frame_t *frame) {
    uint32_t *hash = context;
    const uint8_t head[3] = {(uint8_t)frame->id, (uint8_t)(frame->id >> 8), frame->length};
    *hash = add(add(*hash, head, sizeof head), frame->data, frame->length);
}

void firmware_main(void) {
    static controller_t controller;
    static controller_inbox_t inbox;
    uint32_t hash;
    controller_outbox_t outbox = {.sink = {add_frame, &hash}};
    record_t record;
    platform_open();
    while (record_read(&record)) {
        if (record.kind != RECORD_TICK) {
            record_boot(&record, &controller);
            continue;
        }
        record_read_inbox(&record, &inbox);
        hash = 2166136261u;
        controller_step(&controller, record.now_us, &inbox, &outbox);
        const uint8_t bytes[4] = {(uint8_t)hash, (uint8_t)(hash >> 8), (uint8_t)(hash >> 16), (uint8_t)(hash >> 24)};
        platform_write(bytes, sizeof bytes);
    }
    platform_close();
}
