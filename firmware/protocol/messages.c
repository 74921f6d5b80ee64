#include "messages.h"

#include "../maths/float_bits.h"
#include "can_protocol.h"
#include "comanip_dbc.h"
#include "comanip_schema.h"

/* A frame of this kind: the generated packing writes all of its data. */
static void begin(can_frame_t *frame, frame_kind_t kind) {
    frame->timestamp_us = 0;
    frame->id = frame_table[kind].id;
    frame->length = frame_table[kind].length;
    frame->fd = true;
}

/* Rounds to nearest. If the signal cannot carry the value, NaN included: 0, and *fits becomes false. */
static int32_t quantise(float value, float per_unit, int32_t minimum, int32_t maximum, bool *fits) {
    if (float_magnitude_bits(value) == 0u) { /* what a smaller arm's joints leave empty: most of a JointCmd */
        return 0;
    }
    const float scaled = value * per_unit;
    const uint32_t magnitude = float_magnitude_bits(scaled);
    const bool is_negative = float_is_negative(scaled);
    const bool fits_either_way = magnitude <= float_magnitude_bits((float)maximum) && (minimum != 0 || !is_negative);
    if (fits_either_way || (is_negative && magnitude <= float_magnitude_bits((float)minimum))) {
        return float_nearest(scaled); /* raw values have 24 bits at most: the code generator checks it */
    }
    *fits = false;
    return 0;
}

#define QUANTISE(fits, value, SIGNAL)                                                                                  \
    quantise((value), COMANIP_##SIGNAL##_PER_UNIT, COMANIP_##SIGNAL##_RAW_MIN, COMANIP_##SIGNAL##_RAW_MAX, &(fits))

/* The raw value goes into `raw_member`, of the C type `raw_type`. */
#define PACK(fits, value, SIGNAL, raw_type, raw_member) ((raw_member) = (raw_type)QUANTISE(fits, value, SIGNAL))

#define UNPACK(SIGNAL, raw) ((float)(raw) * COMANIP_##SIGNAL##_RESOLUTION)

static protocol_status_t status_of(bool fits) {
    return fits ? PROTOCOL_OK : PROTOCOL_OUT_OF_RANGE;
}

#include "comanip_messages.inc"
