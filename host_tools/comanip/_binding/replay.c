/* See replay.h. */
#include "replay.h"

#include <string.h>

#include "comanip_build_hash.h"
#include "replay_inbox.h"
#include "replay_store.h"

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
    replay_boot(self, arm);
}

/* ---- differences */

void replay_end(replay_t *self, replay_result_t result, uint32_t place) {
    if (self->result == REPLAY_EQUAL || place < self->place) {
        self->result = result;
        self->place = place;
    }
}

void replay_note_lost(replay_t *self, frame_kind_t kind, uint8_t counter) {
    self->sent = (can_frame_t){.id = frame_table[kind].id, .length = E2E_HEADER_BYTES, .data = {0, 0, counter}};
    replay_end(self, REPLAY_LOST, self->tick_place);
}

/* ---- what it had sent */

static void compare_frame(replay_t *self, const can_frame_t *sent) {
    const frame_kind_t kind = kind_of(sent);
    const uint32_t place = self->cursor[kind];
    if (place == REPLAY_NO_FRAME) {
        if (self->next[self->tick_place] != REPLAY_NO_FRAME && self->result == REPLAY_EQUAL) { /* else the log ends within the tick */
            self->sent = *sent;
            replay_end(self, REPLAY_NOT_IN_LOG, self->tick_place);
        }
        return;
    }
    const can_frame_t *recorded = &self->log[place];
    if (recorded->length != sent->length || memcmp(recorded->data, sent->data, sent->length) != 0) {
        if (self->result == REPLAY_EQUAL || place < self->place) {
            self->sent = *sent;
        }
        replay_end(self, REPLAY_DIFFERENT, place);
    }
    self->cursor[kind] = self->next[place];
    self->compared++;
}

/* Frames of the firmware before `limit` that the replay has not sent. */
static void find_unsent(replay_t *self, uint32_t limit) {
    for (int kind = 0; kind < FRAME_KIND_COUNT; kind++) {
        if (self->from_firmware[kind] && self->cursor[kind] < limit) {
            replay_end(self, REPLAY_NOT_SENT, self->cursor[kind]);
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
    replay_stamp_inbox(self, trace);
    self->inbox.save_over = false;
    controller_step(&self->controller, trace->now_us, &self->inbox, &self->outbox);
    if (replay_ends_save(self)) {
        self->controller = self->before;
        controller_step(&self->controller, trace->now_us, &self->inbox, &self->outbox);
    }
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
static bool try_plan(replay_t *self, const tick_trace_t *trace, replay_plan_t plan) {
    self->controller = self->before;
    memcpy(self->cursor, self->cursor_before, sizeof self->cursor);
    if (!replay_fill_inbox(self, trace, plan)) {
        return false;
    }
    step(self, trace);
    while ((uint8_t)self->controller.receiver.rejected != trace->rejected_frames && replay_read_refused(self)) {
        step(self, trace);
    }
    return true;
}

/* The firmware's tick with what it had read. False: nothing fits. */
static bool redo_tick(replay_t *self, const can_frame_t *recorded, const tick_trace_t *trace) {
    int first_possible = REPLAY_READ_PLANS;
    for (int plan = REPLAY_READ_ALL; plan < REPLAY_READ_PLANS && self->result == REPLAY_EQUAL; plan++) {
        if (try_plan(self, trace, (replay_plan_t)plan)) {
            if (has_sent(self, recorded)) {
                return true;
            }
            first_possible = first_possible == REPLAY_READ_PLANS ? plan : first_possible;
        }
    }
    return first_possible != REPLAY_READ_PLANS && try_plan(self, trace, (replay_plan_t)first_possible);
}

static void replay_tick(replay_t *self) {
    const can_frame_t *recorded = &self->log[self->tick_place];
    if (!replay_has_right_crc(recorded, FRAME_TICK_TRACE)) {
        replay_end(self, REPLAY_DAMAGED, self->tick_place);
        return;
    }
    tick_trace_t trace;
    tick_trace_unpack(recorded, &trace);
    if (is_reboot(self, recorded)) {
        find_unsent(self, self->former_tick_place);
        replay_boot(self, self->controller.arm);
        self->boots++;
    }
    self->before = self->controller;
    memcpy(self->cursor_before, self->cursor, sizeof self->cursor);
    if (!redo_tick(self, recorded, &trace)) {
        if (self->result == REPLAY_EQUAL) {
            replay_note_lost(self, FRAME_OPERATOR_COMMAND, trace.last_counter[FRAME_OPERATOR_COMMAND]);
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
