/* Splits messages into classic CAN frames and joins them again: see can_classic.h. */
#include "can_classic.h"

#include <string.h>

#include "../arms/arm.h"
#include "comanip_dbc.h"
#include "rotation_code.h"

#define FRAME_ROW(name, id, bytes, data_id, period_ms, timeout_ms, to_firmware)                                        \
    {id, bytes, data_id, period_ms, timeout_ms, to_firmware},
const frame_description_t classic_table[CLASSIC_FRAME_COUNT] = {COMANIP_CLASSIC_FRAMES(FRAME_ROW)};

_Static_assert(CLASSIC_MAX_PARTS == ARM_MAX_JOINTS, "a part of JointCmd for each joint");

typedef uint8_t message_t[CAN_FRAME_MAX_BYTES];
typedef uint8_t part_t[CLASSIC_MAX_BYTES];

/* `raw` is the struct that cantools generated for a message or a part. */
#define FROM_MESSAGE(name, raw)                                                                                        \
    struct comanip_##name##_t raw;                                                                                     \
    (void)comanip_##name##_unpack(&raw, message, sizeof(message_t))
#define FROM_PART(name, raw, i)                                                                                        \
    struct comanip_classic_##name##_t raw;                                                                             \
    (void)comanip_classic_##name##_unpack(&raw, part[i], sizeof(part_t))
#define TO_MESSAGE(name, raw) (void)comanip_##name##_pack(message, &(raw), sizeof(message_t))
#define TO_PART(name, raw, i) (void)comanip_classic_##name##_pack(part[i], &(raw), sizeof(part_t))

/* ---- conversion to lower resolution */

static int32_t divide_rounding(int32_t value, int32_t step) {
    return (value + (value < 0 ? -step : step) / 2) / step;
}

/* Divides and rounds. Returns false and sets *coarse to 0 if the result is beyond +-maximum. */
static bool coarsen(int32_t fine, int32_t step, int32_t maximum, int32_t *coarse) {
    const int32_t rounded = divide_rounding(fine, step);
    const bool fits = rounded >= -maximum && rounded <= maximum;
    *coarse = fits ? rounded : 0;
    return fits;
}

/* Factor that converts a quaternion component with `bits` fractional bits to the fixed-point format of
 * rotation_code.h. */
#define ROTATION_STEP(bits) ((int32_t)1 << (ROTATION_CODE_ONE_BITS - (bits)))

/* ---- codec of each message */

typedef struct {
    classic_frame_t first;
    uint8_t parts;
    bool (*split)(const message_t message, part_t part[]);
    void (*join)(part_t part[], message_t message);
} codec_t;

#include "comanip_classic.inc"

classic_frame_t classic_first(frame_kind_t kind) {
    return codec_table[kind].first;
}

uint8_t classic_parts(frame_kind_t kind, uint8_t joint_count) {
    return kind == FRAME_JOINT_CMD ? joint_count : codec_table[kind].parts;
}

bool classic_find(uint16_t id, classic_frame_t *frame, frame_kind_t *kind) {
    for (int k = 0; k < FRAME_KIND_COUNT; k++) {
        for (uint8_t i = 0; i < codec_table[k].parts; i++) {
            if (classic_table[codec_table[k].first + i].id == id) {
                *frame = (classic_frame_t)(codec_table[k].first + i);
                *kind = (frame_kind_t)k;
                return true;
            }
        }
    }
    return false;
}

bool classic_split(frame_kind_t kind, const message_t message, part_t part[CLASSIC_MAX_PARTS]) {
    return codec_table[kind].split(message, part);
}

void classic_join(frame_kind_t kind, part_t part[CLASSIC_MAX_PARTS], message_t message) {
    codec_table[kind].join(part, message);
}

/* ---- timestamp of a HandPose */

#define STAMP_BYTE COMANIP_HAND_POSE_T_US_BYTE

uint32_t classic_unwrap_stamp(message_t message, uint32_t expected_us) {
    uint32_t stamp_us = 0;
    for (int i = 0; i < 4; i++) {
        stamp_us |= (uint32_t)message[STAMP_BYTE + i] << 8 * i;
    }
    const uint32_t ahead_us = (stamp_us - expected_us) % CLASSIC_STAMP_PERIOD_US;
    stamp_us = expected_us + ahead_us - (ahead_us >= CLASSIC_STAMP_PERIOD_US / 2u ? CLASSIC_STAMP_PERIOD_US : 0u);
    for (int i = 0; i < 4; i++) {
        message[STAMP_BYTE + i] = (uint8_t)(stamp_us >> 8 * i);
    }
    return stamp_us;
}
