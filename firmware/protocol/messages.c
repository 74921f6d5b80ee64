/* Packs and unpacks messages: see messages.h. */
#include "messages.h"

#include "../maths/float_bits.h"
#include "comanip_dbc.h"
#include "comanip_schema.h"
#include "frame_table.h"

/* Starts a frame of this kind. The generated code then writes all of its data. */
static void begin(can_frame_t *frame, frame_kind_t kind) {
    frame->timestamp_us = 0;
    frame->id = frame_table[kind].id;
    frame->length = frame_table[kind].length;
    frame->fd = true;
}

/* Rounds to the nearest raw value. If the signal cannot carry the value, or the value is NaN, returns 0 and clears
 * *fits. */
static int32_t quantise(float value, float per_unit, int32_t minimum, int32_t maximum, bool *fits) {
    if (float_magnitude_bits(value) == 0u) { /* common in JointCmd, for the joints that the arm does not have */
        return 0;
    }
    const float scaled = value * per_unit;
    const uint32_t magnitude = float_magnitude_bits(scaled);
    const bool is_negative = float_is_negative(scaled);
    const bool fits_either_way = magnitude <= float_magnitude_bits((float)maximum) && (minimum != 0 || !is_negative);
    if (fits_either_way || (is_negative && magnitude <= float_magnitude_bits((float)minimum))) {
        return float_nearest(scaled); /* at most 24 bits, as the code generator checks */
    }
    *fits = false;
    return 0;
}

#define QUANTISE(fits, value, SIGNAL)                                                                                  \
    quantise((value), COMANIP_##SIGNAL##_PER_UNIT, COMANIP_##SIGNAL##_RAW_MIN, COMANIP_##SIGNAL##_RAW_MAX, &(fits))

/* Stores the raw value in `raw_member`, whose C type is `raw_type`. */
#define PACK(fits, value, SIGNAL, raw_type, raw_member) ((raw_member) = (raw_type)QUANTISE(fits, value, SIGNAL))

#define UNPACK(SIGNAL, raw) ((float)(raw) * COMANIP_##SIGNAL##_RESOLUTION)

static protocol_status_t status_of(bool fits) {
    return fits ? PROTOCOL_OK : PROTOCOL_OUT_OF_RANGE;
}

#include "comanip_messages.inc"
