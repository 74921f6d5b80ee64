/* See replay.h. */
#include "replay.h"

#include <string.h>

#include "comanip_build_hash.h"

#define LOOK_AHEAD_TICKS 4 /* JointState's timeout, in ticks, and the tick itself */

uint64_t replay_build_hash(void) {
    return COMANIP_BUILD_HASH;
}

/* ---- the log */

static frame_kind_t kind_of(const can_frame_t *frame) {
    int kind = 0;
    while (kind < FRAME_KIND_COUNT && frame_table[kind].id != frame->id) {
        kind++;
    }
    return (frame_kind_t)kind;
}

void replay_init(replay_t *self, const arm_t *arm, const can_frame_t log[], uint32_t count, uint8_t kind[],
                 uint32_t next[], const bool to_firmware[], const bool from_firmware[]) {
    memset(self, 0, sizeof *self);
    self->log = log;
    self->count = count;
    self->kind = kind;
    self->next = next;
    memcpy(self->to_firmware, to_firmware, sizeof self->to_firmware);
    memcpy(self->from_firmware, from_firmware, sizeof self->from_firmware);
    for (int i = 0; i < FRAME_KIND_COUNT; i++) {
        self->cursor[i] = REPLAY_NO_FRAME;
    }
    for (uint32_t i = count; i-- > 0;) {
        kind[i] = (uint8_t)kind_of(&log[i]);
        if (kind[i] < FRAME_KIND_COUNT) {
            next[i] = self->cursor[kind[i]];
            self->cursor[kind[i]] = i;
        }
    }
    self->tick_place = self->cursor[FRAME_TICK_TRACE];
    self->former_tick_place = 0;
    self->boots = 1;
    controller_init(&self->controller, arm);
}

/* Follows the receiver's counter, as the firmware does. False: the frame leaves no mark on it. */
static bool follow(e2e_receiver_t *receiver, const can_frame_t *frame, frame_kind_t kind, bool *crc_right) {
    *crc_right = false;
    if (frame->length != frame_table[kind].length) {
        return false;
    }
    e2e_status_t status = e2e_check(receiver, frame->data, frame->length, frame_table[kind].data_id);
    *crc_right = status != E2E_WRONG_CRC;
    return *crc_right && status != E2E_REPEATED;
}

static bool has_right_crc(const can_frame_t *frame, frame_kind_t kind) {
    e2e_receiver_t receiver = {0};
    bool crc_right;
    (void)follow(&receiver, frame, kind, &crc_right);
    return crc_right;
}

static void end(replay_t *self, replay_result_t result, uint32_t place) {
    if (self->result == REPLAY_EQUAL || place < self->place) {
        self->result = result;
        self->place = place;
    }
}

/* ---- what a tick had read */

static bool add_to_inbox(replay_t *self, uint32_t place) {
    if (self->inbox.count == CONTROLLER_INBOX_FRAMES) {
        return false;
    }
    int i = self->inbox.count++;
    for (; i > 0 && self->place_of[i - 1] > place; i--) { /* in the order of the bus */
        self->place_of[i] = self->place_of[i - 1];
        self->inbox.frame[i] = self->inbox.frame[i - 1];
    }
    self->place_of[i] = place;
    self->inbox.frame[i] = self->log[place];
    return true;
}

/* A firmware that has just booted had not heard what came before: only the last frame before the tick is sure. */
static void skip_unheard(replay_t *self, frame_kind_t kind, uint8_t counter) {
    for (uint32_t i = self->cursor[kind]; i < self->tick_place; i = self->next[i]) {
        if (self->log[i].data[2] == counter && has_right_crc(&self->log[i], kind)) {
            self->cursor[kind] = i;
        }
    }
}

static void note_lost(replay_t *self, frame_kind_t kind, uint8_t counter) {
    self->sent = (can_frame_t){.id = frame_table[kind].id, .length = E2E_HEADER_BYTES, .data = {0, 0, counter}};
    end(self, REPLAY_LOST, self->tick_place);
}

/* Where the firmware read less than the bus brought, for its queue was full after a pause, the log does not say which frames it
 * had lost. In this order it is tried with which of them the tick sends the recorded TickTrace. */
typedef enum {
    READ_ALL,            /* up to the traced counter */
    READ_BRIDGED_STATES, /* of states just so many that no counter jumps by more than end-to-end protection allows */
    READ_NEWEST_STATES,  /* of states the newest alone */
    READ_NEWEST,         /* of poses as well */
    READ_PLANS
} read_plan_t;

#define BRIDGE 8 /* below E2E_MAX_DELTA */

static bool is_read(read_plan_t plan, frame_kind_t kind, uint8_t distance) {
    if (plan == READ_ALL || distance == 0u) {
        return true;
    }
    if (kind == FRAME_HAND_POSE) {
        return plan < READ_NEWEST;
    }
    if (frame_table[kind].period_ms == 0u) {
        return true; /* an operator's frame: its answer is in the log */
    }
    return plan == READ_BRIDGED_STATES && distance % BRIDGE == 0u;
}

/* Takes the frames of one id up to the one with the traced counter. False: there is none, or more than a tick reads. */
static bool read_kind(replay_t *self, frame_kind_t kind, const tick_trace_t *trace, read_plan_t plan) {
    e2e_receiver_t receiver = self->controller.receiver.e2e[kind];
    const uint8_t wanted = trace->last_counter[kind];
    uint32_t damaged = REPLAY_NO_FRAME;
    if (!trace->received[kind] || (receiver.started && receiver.counter == wanted)) {
        return true;
    }
    if (!receiver.started) {
        skip_unheard(self, kind, wanted);
    }
    uint32_t place = self->cursor[kind];
    bool fits = true;
    for (int i = 0; i < UINT8_MAX && place != REPLAY_NO_FRAME; i++, place = self->next[place]) {
        bool crc_right;
        (void)follow(&receiver, &self->log[place], kind, &crc_right);
        if (!crc_right && damaged == REPLAY_NO_FRAME) {
            damaged = place;
        }
        if (is_read(plan, kind, (uint8_t)(wanted - self->log[place].data[2]))) {
            fits = add_to_inbox(self, place) && fits;
        }
        if (crc_right && receiver.counter == wanted) {
            self->cursor[kind] = self->next[place];
            return fits;
        }
    }
    if (damaged != REPLAY_NO_FRAME) {
        end(self, REPLAY_DAMAGED, damaged);
    } else {
        note_lost(self, kind, wanted);
    }
    return false;
}

/* The next frame, in the order of the bus, that the firmware may have read and refused without following its counter. */
static bool read_refused(replay_t *self) {
    int best = FRAME_KIND_COUNT;
    for (int kind = 0; kind < FRAME_KIND_COUNT; kind++) {
        const uint32_t place = self->cursor[kind];
        if (!self->to_firmware[kind] || place >= self->tick_place) {
            continue;
        }
        e2e_receiver_t receiver = self->controller.receiver.e2e[kind];
        bool crc_right;
        bool leaves_a_mark = follow(&receiver, &self->log[place], (frame_kind_t)kind, &crc_right);
        if (!leaves_a_mark && (best == FRAME_KIND_COUNT || place < self->cursor[best])) {
            best = kind;
        }
    }
    if (best == FRAME_KIND_COUNT || !add_to_inbox(self, self->cursor[best])) {
        return false;
    }
    self->cursor[best] = self->next[self->cursor[best]];
    return true;
}

/* ---- times of reception */

/* The oldest stamp with which the drive stays fresh in the ticks that say so, until its next frame. */
static uint32_t joint_stamp_us(const replay_t *self, frame_kind_t kind, const tick_trace_t *trace) {
    const uint32_t timeout_us = 1000u * frame_table[kind].timeout_ms;
    uint32_t stamp_us = trace->now_us - timeout_us - 1u;
    uint8_t counter = trace->last_counter[kind];
    uint32_t place = self->tick_place;
    for (int i = 0; i < LOOK_AHEAD_TICKS && place != REPLAY_NO_FRAME; i++, place = self->next[place]) {
        tick_trace_t ahead;
        tick_trace_unpack(&self->log[place], &ahead);
        const uint8_t delta = (uint8_t)(ahead.last_counter[kind] - counter);
        if (delta >= 1u && delta <= E2E_MAX_DELTA) {
            break;
        }
        counter = ahead.last_counter[kind];
        if (ahead.drives_fresh) {
            stamp_us = ahead.now_us - timeout_us;
        }
    }
    return (int32_t)(trace->now_us - stamp_us) < 0 ? trace->now_us : stamp_us;
}

static void stamp_inbox(replay_t *self, const tick_trace_t *trace) {
    for (int i = 0; i < self->inbox.count; i++) {
        const frame_kind_t kind = (frame_kind_t)self->kind[self->place_of[i]];
        uint32_t stamp_us = trace->now_us;
        if (kind == FRAME_HAND_POSE) {
            stamp_us -= trace->hand_age_us;
        } else if (kind >= FRAME_JOINT_STATE0 && kind <= FRAME_JOINT_STATE7) {
            stamp_us = joint_stamp_us(self, kind, trace);
        }
        self->inbox.frame[i].timestamp_us = stamp_us;
    }
}

/* ---- what it had sent */

static void compare_frame(replay_t *self, const can_frame_t *sent) {
    const frame_kind_t kind = kind_of(sent);
    const uint32_t place = self->cursor[kind];
    if (place == REPLAY_NO_FRAME) {
        if (self->next[self->tick_place] != REPLAY_NO_FRAME && self->result == REPLAY_EQUAL) { /* else the log ends within the tick */
            self->sent = *sent;
            end(self, REPLAY_NOT_IN_LOG, self->tick_place);
        }
        return;
    }
    const can_frame_t *recorded = &self->log[place];
    if (recorded->length != sent->length || memcmp(recorded->data, sent->data, sent->length) != 0) {
        if (self->result == REPLAY_EQUAL || place < self->place) {
            self->sent = *sent;
        }
        end(self, REPLAY_DIFFERENT, place);
    }
    self->cursor[kind] = self->next[place];
    self->compared++;
}

/* Frames of the firmware before `limit` that the replay has not sent. */
static void find_unsent(replay_t *self, uint32_t limit) {
    for (int kind = 0; kind < FRAME_KIND_COUNT; kind++) {
        if (self->from_firmware[kind] && self->cursor[kind] < limit) {
            end(self, REPLAY_NOT_SENT, self->cursor[kind]);
        }
    }
}

/* ---- a tick */

/* Another process of the same firmware has begun: its counters start over, and it says who it is. */
static bool is_reboot(const replay_t *self, const can_frame_t *recorded) {
    const uint32_t heartbeat = self->cursor[FRAME_FIRMWARE_HEARTBEAT];
    return self->ticks > 0u && recorded->data[2] == 0u && heartbeat != REPLAY_NO_FRAME &&
           self->log[heartbeat].data[0] == HEARTBEAT_BOOT_UP &&
           self->cursor[FRAME_FIRMWARE_IDENTITY] < self->next[self->tick_place];
}

static void step(replay_t *self, const tick_trace_t *trace) {
    self->controller = self->before;
    stamp_inbox(self, trace);
    controller_step(&self->controller, trace->now_us, &self->inbox, &self->outbox);
}

static bool has_sent(const replay_t *self, const can_frame_t *recorded) {
    for (int i = 0; i < self->outbox.count; i++) {
        const can_frame_t *sent = &self->outbox.frame[i];
        if (sent->id == recorded->id) {
            return sent->length == recorded->length && memcmp(sent->data, recorded->data, sent->length) == 0;
        }
    }
    return false;
}

/* False: it cannot have been so. */
static bool try_plan(replay_t *self, const tick_trace_t *trace, read_plan_t plan) {
    self->controller = self->before;
    memcpy(self->cursor, self->cursor_before, sizeof self->cursor);
    self->inbox.count = 0;
    for (int kind = 0; kind < FRAME_KIND_COUNT; kind++) {
        if (self->to_firmware[kind] && !read_kind(self, (frame_kind_t)kind, trace, plan)) {
            return false;
        }
    }
    step(self, trace);
    while ((uint8_t)self->controller.receiver.rejected != trace->rejected_frames && read_refused(self)) {
        step(self, trace);
    }
    return true;
}

/* The firmware's tick with what it had read. False: nothing fits. */
static bool redo_tick(replay_t *self, const can_frame_t *recorded, const tick_trace_t *trace) {
    int first_possible = READ_PLANS;
    for (int plan = READ_ALL; plan < READ_PLANS && self->result == REPLAY_EQUAL; plan++) {
        if (try_plan(self, trace, (read_plan_t)plan)) {
            if (has_sent(self, recorded)) {
                return true;
            }
            first_possible = first_possible == READ_PLANS ? plan : first_possible;
        }
    }
    return first_possible != READ_PLANS && try_plan(self, trace, (read_plan_t)first_possible);
}

static void replay_tick(replay_t *self) {
    const can_frame_t *recorded = &self->log[self->tick_place];
    if (!has_right_crc(recorded, FRAME_TICK_TRACE)) {
        end(self, REPLAY_DAMAGED, self->tick_place);
        return;
    }
    tick_trace_t trace;
    tick_trace_unpack(recorded, &trace);
    if (is_reboot(self, recorded)) {
        find_unsent(self, self->former_tick_place);
        controller_init(&self->controller, self->controller.arm);
        self->boots++;
    }
    self->before = self->controller;
    memcpy(self->cursor_before, self->cursor, sizeof self->cursor);
    if (!redo_tick(self, recorded, &trace)) {
        if (self->result == REPLAY_EQUAL) {
            note_lost(self, FRAME_OPERATOR_COMMAND, trace.last_counter[FRAME_OPERATOR_COMMAND]);
        }
        return;
    }
    for (int i = 0; i < self->outbox.count; i++) {
        compare_frame(self, &self->outbox.frame[i]);
    }
    find_unsent(self, self->former_tick_place); /* within the tick, the bus may have brought them in another order */
    self->fed += self->inbox.count;
    self->ticks++;
    self->former_tick_place = self->tick_place;
    self->tick_place = self->next[self->tick_place];
}

bool replay_run(replay_t *self, uint32_t end_place) {
    while (self->result == REPLAY_EQUAL && self->tick_place < end_place) {
        replay_tick(self);
    }
    return self->result == REPLAY_EQUAL && self->tick_place != REPLAY_NO_FRAME;
}

void replay_finish(replay_t *self) {
    if (self->result != REPLAY_EQUAL) {
        return;
    }
    const uint32_t command = self->cursor[FRAME_JOINT_CMD];
    const bool within_tick = command == REPLAY_NO_FRAME || self->next[command] == REPLAY_NO_FRAME;
    find_unsent(self, within_tick ? self->former_tick_place : REPLAY_NO_FRAME);
}
