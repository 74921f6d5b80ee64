/* Sends and receives messages in either profile: see can_transport.h. */
#include "can_transport.h"

#include <string.h>

#include "../arms/arm.h"
#include "comanip_schema.h"

_Static_assert(FRAME_KIND_COUNT < 32, "frame kinds must fit in a 32-bit mask");
_Static_assert(TRANSPORT_MAX_FRAMES == CLASSIC_MAX_PARTS, "each part is one frame");

#define EVENT_PARTS_WITHIN_MS 50u /* timeout for the parts of an event message */

/* ---- frames of a message */

static bool is_classic(can_profile_t profile) {
    return can_profile_in_force(profile) == CAN_PROFILE_CLASSIC;
}

/* Returns whether the message is converted to classic CAN frames. A message without classic CAN frames
 * of its own, such as FirmwareHeartbeat, is the same in both profiles. */
static bool is_translated(can_profile_t profile, frame_kind_t kind) {
    return is_classic(profile) && classic_parts(kind, ARM_MAX_JOINTS) != 0u;
}

bool transport_is_same_frame(frame_kind_t kind) {
    return classic_parts(kind, ARM_MAX_JOINTS) == 0u && frame_table[kind].length <= CLASSIC_MAX_BYTES;
}

/* Returns the description of the message's first frame. */
static const frame_description_t *description_of(can_profile_t profile, frame_kind_t kind) {
    return is_translated(profile, kind) ? &classic_table[classic_first(kind)] : &frame_table[kind];
}

uint16_t transport_first_id(can_profile_t profile, frame_kind_t kind) {
    return description_of(profile, kind)->id;
}

uint16_t transport_period_ms(can_profile_t profile, frame_kind_t kind) {
    return description_of(profile, kind)->period_ms;
}

uint16_t transport_timeout_ms(can_profile_t profile, frame_kind_t kind) {
    return description_of(profile, kind)->timeout_ms;
}

float transport_hand_range_m(can_profile_t profile) {
    return is_classic(profile)
               ? (float)COMANIP_CLASSIC_HAND_POSITION_X_M_RAW_MAX * COMANIP_CLASSIC_HAND_POSITION_X_M_RESOLUTION
               : (float)COMANIP_HAND_POSE_X_M_RAW_MAX * COMANIP_HAND_POSE_X_M_RESOLUTION;
}

uint8_t transport_ids_to_firmware(can_profile_t profile, uint16_t ids[TRANSPORT_MAX_IDS]) {
    uint8_t count = 0;
    for (int i = 0; i < FRAME_KIND_COUNT; i++) {
        if (frame_table[i].to_firmware && (!is_classic(profile) || transport_is_same_frame((frame_kind_t)i))) {
            ids[count++] = frame_table[i].id;
        }
    }
    for (int i = 0; is_classic(profile) && i < CLASSIC_FRAME_COUNT; i++) {
        if (classic_table[i].to_firmware) {
            ids[count++] = classic_table[i].id;
        }
    }
    return count;
}

/* ---- sending */

void transport_sender_init(transport_sender_t *self, can_profile_t profile, uint8_t joint_count) {
    *self = (transport_sender_t){.profile = profile, .joint_count = joint_count};
}

static bool send_parts(transport_sender_t *self, frame_kind_t kind, can_frame_t *message, const can_sink_t *sink) {
    uint8_t part[CLASSIC_MAX_PARTS][CLASSIC_MAX_BYTES];
    if (!classic_split(kind, message->data, part)) {
        return false;
    }
    const uint8_t parts = classic_parts(kind, self->joint_count);
    const uint8_t counter = self->counters.counter[kind]++;
    for (uint8_t i = 0; i < parts; i++) {
        const frame_description_t *description = &classic_table[classic_first(kind) + i];
        can_frame_t frame = {.id = description->id, .length = description->length};
        memcpy(frame.data, part[i], description->length);
        e2e_profile2_protect(frame.data, frame.length, description->data_id, counter);
        sink->send(sink->context, &frame);
    }
    return true;
}

bool transport_send(transport_sender_t *self, can_frame_t *message, const can_sink_t *sink) {
    frame_kind_t kind;
    if (is_classic(self->profile) && protocol_find(message->id, &kind) && is_translated(self->profile, kind)) {
        return send_parts(self, kind, message, sink);
    }
    message->fd = !is_classic(self->profile);
    if (!message->fd && message->length > CLASSIC_MAX_BYTES) {
        return false;
    }
    protocol_protect(&self->counters, message);
    sink->send(sink->context, message);
    return true;
}

/* ---- receiving */

void transport_receiver_init(transport_receiver_t *self, can_profile_t profile, uint8_t joint_count, uint32_t kinds) {
    memset(self, 0, sizeof *self);
    self->profile = profile;
    self->joint_count = joint_count;
    self->kinds = kinds;
}

/* Index in `pending` of each kind that has several parts. */
#define PENDING_INDEX(name, index) [FRAME_##name] = (index),
static const uint8_t pending_index[FRAME_KIND_COUNT] = {COMANIP_MULTIPART(PENDING_INDEX)};

/* A counter repeats after 16 messages. A part that has waited longer than the timeout is therefore taken to belong to
 * another message. */
static bool is_too_old(const transport_pending_t *pending, frame_kind_t kind, uint32_t now_us) {
    uint32_t within_ms = transport_timeout_ms(CAN_PROFILE_CLASSIC, kind);
    return now_us - pending->begun_us > 1000u * (within_ms != 0u ? within_ms : EVENT_PARTS_WITHIN_MS);
}

/* Extends the timestamp of a valid pose to 32 bits; that of an invalid pose has no meaning. */
static void restore_stamp(transport_receiver_t *self, can_frame_t *message) {
    if ((message->data[COMANIP_HAND_POSE_VALID_BYTE] & COMANIP_HAND_POSE_VALID_MASK) == 0u) {
        return;
    }
    uint32_t expected_us = self->pose_stamp_us + (message->timestamp_us - self->pose_received_us);
    self->pose_stamp_us = classic_unwrap_stamp(message->data, expected_us);
    self->pose_received_us = message->timestamp_us;
}

/* Joins the parts into the message. */
static void complete(transport_receiver_t *self, frame_kind_t kind, uint8_t counter, uint8_t part[][CLASSIC_MAX_BYTES],
                     can_frame_t *frame) {
    frame->id = frame_table[kind].id;
    frame->length = frame_table[kind].length;
    classic_join(kind, part, frame->data);
    if (kind == FRAME_HAND_POSE) {
        restore_stamp(self, frame);
    }
    self->protocol.e2e[kind] = (e2e_receiver_t){.started = true, .counter = counter};
}

static protocol_status_t take_part(transport_receiver_t *self, frame_kind_t kind, uint8_t parts, uint8_t index,
                                   uint8_t counter, can_frame_t *frame) {
    transport_pending_t *pending = &self->pending[pending_index[kind]];
    if (pending->received == 0u || pending->counter != counter || is_too_old(pending, kind, frame->timestamp_us)) {
        pending->received = 0;
        pending->counter = counter;
        pending->begun_us = frame->timestamp_us;
    }
    memcpy(pending->part[index], frame->data, CLASSIC_MAX_BYTES);
    pending->received = (uint8_t)(pending->received | (1u << index));
    if (pending->received != (1u << parts) - 1u) {
        return PROTOCOL_INCOMPLETE;
    }
    pending->received = 0;
    complete(self, kind, counter, pending->part, frame);
    return PROTOCOL_OK;
}

static protocol_status_t receive_classic(transport_receiver_t *self, classic_frame_t number, frame_kind_t kind,
                                         can_frame_t *frame) {
    const frame_description_t *description = &classic_table[number];
    if (frame->length != description->length) {
        return PROTOCOL_WRONG_LENGTH;
    }
    const uint8_t parts = classic_parts(kind, self->joint_count), index = (uint8_t)(number - classic_first(kind));
    if (index >= parts) {
        return PROTOCOL_UNKNOWN_ID; /* the arm does not have this joint */
    }
    e2e_status_t status = e2e_profile2_check(&self->classic[number], frame->data, frame->length, description->data_id);
    const uint8_t counter = self->classic[number].counter;
    if (parts == 1u && status != E2E_WRONG_CRC) {
        self->protocol.e2e[kind] = self->classic[number];
    }
    if (status < 0 && !(status == E2E_WRONG_SEQUENCE && description->period_ms == 0u)) {
        return PROTOCOL_NOT_AUTHENTIC;
    }
    if (parts > 1u) {
        return take_part(self, kind, parts, index, counter, frame);
    }
    uint8_t part[CLASSIC_MAX_PARTS][CLASSIC_MAX_BYTES] = {{0}};
    memcpy(part[0], frame->data, CLASSIC_MAX_BYTES);
    complete(self, kind, counter, part, frame);
    return PROTOCOL_OK;
}

protocol_status_t transport_receive(transport_receiver_t *self, can_frame_t *frame, frame_kind_t *kind) {
    classic_frame_t number = CLASSIC_FRAME_COUNT;
    const bool is_part = is_classic(self->profile) && classic_find(frame->id, &number, kind);
    const bool is_known = is_part || (protocol_find(frame->id, kind) && !is_translated(self->profile, *kind));
    if (!is_known || (self->kinds & (UINT32_C(1) << *kind)) == 0u) {
        return PROTOCOL_UNKNOWN_ID;
    }
    if (!is_part) {
        return protocol_check(&self->protocol, frame, *kind);
    }
    protocol_status_t status = receive_classic(self, number, *kind, frame);
    self->protocol.rejected += status < 0 && status != PROTOCOL_UNKNOWN_ID;
    return status;
}
