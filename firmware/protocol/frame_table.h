/* The frames of the bus on CAN FD, as described in the DBC. can_protocol.c defines the table. */
#ifndef COMANIP_FRAME_TABLE_H
#define COMANIP_FRAME_TABLE_H

#include <stdbool.h>
#include <stdint.h>

#include "comanip_schema.h"

/* FRAME_JOINT_STATE0 + i is the frame of joint i. */
#define COMANIP_FRAME_KIND(name, id, bytes, data_id, period_ms, timeout_ms, to_firmware) FRAME_##name,
typedef enum { COMANIP_FRAMES(COMANIP_FRAME_KIND) FRAME_KIND_COUNT } frame_kind_t;

/* A frame's description in the DBC. */
typedef struct {
    uint16_t id;
    uint8_t length;
    uint16_t data_id;   /* 0 if the frame has no end-to-end protection */
    uint16_t period_ms; /* 0 for an event message */
    uint16_t timeout_ms;
    bool to_firmware; /* the firmware receives this frame */
} frame_description_t;

extern const frame_description_t frame_table[FRAME_KIND_COUNT];

#endif
