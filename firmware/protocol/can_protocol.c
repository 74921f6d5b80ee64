/* Identifies, protects and checks frames: see can_protocol.h. */
#include "can_protocol.h"

#include <string.h>

#include "../arms/arm.h"
#include "comanip_schema.h"

#define FRAME_ROW(name, id, bytes, data_id, period_ms, timeout_ms, to_firmware)                                        \
    [FRAME_##name] = {id, bytes, data_id, period_ms, timeout_ms, to_firmware},
const frame_description_t frame_table[FRAME_KIND_COUNT] = {COMANIP_FRAMES(FRAME_ROW)};

_Static_assert(FRAME_JOINT_STATE7 - FRAME_JOINT_STATE0 + 1 == ARM_MAX_JOINTS, "a JointState for each joint");

static bool is_authentic(protocol_receiver_t *self, const can_frame_t *frame, frame_kind_t kind) {
    const frame_description_t *description = &frame_table[kind];
    if (description->data_id == 0u) {
        return true;
    }
    e2e_status_t status = e2e_check(&self->e2e[kind], frame->data, frame->length, description->data_id);
    return status >= 0 || (status == E2E_WRONG_SEQUENCE && description->period_ms == 0u);
}

bool protocol_find(uint16_t id, frame_kind_t *kind) {
#define ID_CASE(name, id, bytes, data_id, period_ms, timeout_ms, to_firmware)                                          \
    case id: *kind = FRAME_##name; return true;
    switch (id) { /* faster than a loop over the table */
        COMANIP_FRAMES(ID_CASE)
    default: return false;
    }
}

void protocol_protect(protocol_sender_t *self, can_frame_t *frame) {
    frame_kind_t kind;
    if (protocol_find(frame->id, &kind) && frame_table[kind].data_id != 0u) {
        e2e_protect(frame->data, frame->length, frame_table[kind].data_id, self->counter[kind]++);
    }
}

protocol_status_t protocol_check(protocol_receiver_t *self, const can_frame_t *frame, frame_kind_t kind) {
    protocol_status_t status = PROTOCOL_OK;
    if (frame->length != frame_table[kind].length) {
        status = PROTOCOL_WRONG_LENGTH;
    } else if (!is_authentic(self, frame, kind)) {
        status = PROTOCOL_NOT_AUTHENTIC;
    }
    self->rejected += status != PROTOCOL_OK;
    return status;
}

void protocol_trace_inputs(const e2e_receiver_t last[FRAME_KIND_COUNT], tick_trace_t *trace) {
    uint16_t bit = 1;
    trace->received = 0;
#define TRACE_COUNTER(name, member)                                                                                    \
    trace->member = last[FRAME_##name].counter;                                                                        \
    trace->received = (uint16_t)(trace->received | (last[FRAME_##name].started ? bit : 0u));                           \
    bit = (uint16_t)(bit << 1);
    COMANIP_TRACED(TRACE_COUNTER)
}

void protocol_traced_inputs(const tick_trace_t *trace, e2e_receiver_t last[FRAME_KIND_COUNT]) {
    uint16_t bit = 1;
    memset(last, 0, FRAME_KIND_COUNT * sizeof last[0]);
#define TRACED_COUNTER(name, member)                                                                                   \
    last[FRAME_##name].counter = trace->member;                                                                        \
    last[FRAME_##name].started = (trace->received & bit) != 0u;                                                        \
    bit = (uint16_t)(bit << 1);
    COMANIP_TRACED(TRACED_COUNTER)
}
