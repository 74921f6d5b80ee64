/* The bus in virtual time. Each node has a bounded queue, sorted by id, so that arbitration only compares the first
 * ready frame of each node. */
#include "bus.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "../../hal/common/frame_time.h"

#define LOAD_WINDOW_NS INT64_C(10000000)

typedef struct {
    can_frame_t frame;
    int64_t ready_ns;
    int64_t duration_ns;
} pending_t;

typedef struct {
    bus_handler_t handler;
    void *context;
    int count;
    uint8_t order[BUS_QUEUE_FRAMES]; /* slots sorted by id, then by order of sending; free slots from index `count` */
    pending_t slot[BUS_QUEUE_FRAMES];
} node_t;

typedef struct {
    bus_handler_t handler;
    void *context;
} listener_t;

struct bus {
    can_profile_t profile;
    int64_t now_ns;
    int node_count;
    int listener_count;
    node_t node[BUS_MAX_NODES];
    listener_t listener[BUS_MAX_NODES];

    bool on_wire;
    int sender;
    int64_t start_ns, end_ns;
    can_frame_t frame; /* the frame on the wire */

    int64_t window; /* index of the current load window */
    int64_t window_busy_ns;
    int64_t window_busy_peak_ns;
    bus_statistics_t statistics;
};

bus_t *bus_create(can_profile_t profile) {
    bus_t *self = calloc(1, sizeof *self);
    if (self != NULL) {
        self->profile = profile;
    }
    return self;
}

can_profile_t bus_profile(const bus_t *self) {
    return self->profile;
}

void bus_destroy(bus_t *self) {
    free(self);
}

int bus_attach(bus_t *self, bus_handler_t handler, void *context) {
    assert(self->node_count < BUS_MAX_NODES);
    node_t *node = &self->node[self->node_count];
    node->handler = handler;
    node->context = context;
    for (int i = 0; i < BUS_QUEUE_FRAMES; i++) {
        node->order[i] = (uint8_t)i;
    }
    return self->node_count++;
}

void bus_listen(bus_t *self, bus_handler_t handler, void *context) {
    assert(self->listener_count < BUS_MAX_NODES);
    self->listener[self->listener_count++] = (listener_t){.handler = handler, .context = context};
}

bool bus_send(bus_t *self, int node_number, const can_frame_t *frame, int64_t ready_ns) {
    assert(node_number >= 0 && node_number < self->node_count);
    const int64_t duration_ns = frame_time_ns(frame);
    assert(duration_ns > 0); /* an id of more than 11 bits or a length that no DLC encodes is a bug */
    node_t *node = &self->node[node_number];
    if (node->count == BUS_QUEUE_FRAMES) {
        self->statistics.dropped++;
        return false;
    }
    const uint8_t slot = node->order[node->count];
    int index = node->count;
    while (index > 0 && node->slot[node->order[index - 1]].frame.id > frame->id) {
        node->order[index] = node->order[index - 1];
        index--;
    }
    if (index > 0) {
        const pending_t *before = &node->slot[node->order[index - 1]];
        if (before->frame.id == frame->id && ready_ns < before->ready_ns) {
            ready_ns = before->ready_ns; /* frames with equal ids keep their order */
        }
    }
    node->order[index] = slot;
    node->slot[slot] = (pending_t){.frame = *frame, .ready_ns = ready_ns, .duration_ns = duration_ns};
    node->count++;
    return true;
}

typedef struct {
    int node;              /* negative: no frame is ready */
    int index;             /* index into the node's `order` */
    int64_t next_ready_ns; /* if no frame is ready: time at which one will be; INT64_MAX: no frame is queued */
} arbitration_t;

/* Selects the lowest id among the ready frames. If two nodes send the same id, which a real bus forbids, the node with
 * the lower index wins. */
static arbitration_t arbitrate(const bus_t *self) {
    arbitration_t winner = {.node = -1, .index = 0, .next_ready_ns = INT64_MAX};
    uint16_t winner_id = UINT16_MAX;
    for (int n = 0; n < self->node_count; n++) {
        const node_t *node = &self->node[n];
        for (int index = 0; index < node->count; index++) {
            const pending_t *pending = &node->slot[node->order[index]];
            if (pending->ready_ns <= self->now_ns) {
                if (pending->frame.id < winner_id) {
                    winner.node = n;
                    winner.index = index;
                    winner_id = pending->frame.id;
                }
                break;
            }
            if (pending->ready_ns < winner.next_ready_ns) {
                winner.next_ready_ns = pending->ready_ns;
            }
        }
    }
    return winner;
}

/* Puts the next frame on the wire. Returns false if no frame is ready before time_ns. */
static bool start_frame(bus_t *self, int64_t time_ns) {
    if (self->now_ns >= time_ns) {
        return false;
    }
    arbitration_t winner = arbitrate(self);
    if (winner.node < 0) {
        if (winner.next_ready_ns >= time_ns) {
            return false;
        }
        self->now_ns = winner.next_ready_ns;
        winner = arbitrate(self);
    }
    node_t *node = &self->node[winner.node];
    const uint8_t slot = node->order[winner.index];
    node->count--;
    memmove(&node->order[winner.index], &node->order[winner.index + 1], (size_t)(node->count - winner.index));
    node->order[node->count] = slot;

    self->frame = node->slot[slot].frame;
    self->sender = winner.node;
    self->start_ns = self->now_ns;
    self->end_ns = self->now_ns + node->slot[slot].duration_ns;
    self->on_wire = true;
    return true;
}

static void count_busy_time(bus_t *self) {
    self->statistics.frames++;
    self->statistics.busy_ns += self->end_ns - self->start_ns;
    for (int64_t from_ns = self->start_ns; from_ns < self->end_ns;) {
        const int64_t window = from_ns / LOAD_WINDOW_NS;
        const int64_t window_end_ns = (window + 1) * LOAD_WINDOW_NS;
        const int64_t until_ns = self->end_ns < window_end_ns ? self->end_ns : window_end_ns;
        if (window != self->window) {
            self->window = window;
            self->window_busy_ns = 0;
        }
        self->window_busy_ns += until_ns - from_ns;
        if (self->window_busy_ns > self->window_busy_peak_ns) {
            self->window_busy_peak_ns = self->window_busy_ns;
        }
        from_ns = until_ns;
    }
}

static void end_frame(bus_t *self) {
    self->now_ns = self->end_ns;
    self->on_wire = false;
    self->frame.timestamp_us = (uint32_t)(self->end_ns / 1000);
    count_busy_time(self);
    for (int i = 0; i < self->listener_count; i++) {
        self->listener[i].handler(self->listener[i].context, &self->frame, self->end_ns);
    }
    for (int i = 0; i < self->node_count; i++) {
        if (i != self->sender && self->node[i].handler != NULL) {
            self->node[i].handler(self->node[i].context, &self->frame, self->end_ns);
        }
    }
}

void bus_run_until(bus_t *self, int64_t time_ns) {
    while (self->on_wire || start_frame(self, time_ns)) {
        if (self->end_ns > time_ns) {
            break;
        }
        end_frame(self);
    }
    if (self->now_ns < time_ns) {
        self->now_ns = time_ns;
    }
}

int64_t bus_epoch_ns(const bus_t *self) {
    (void)self;
    return 0;
}

bus_statistics_t bus_statistics(const bus_t *self) {
    bus_statistics_t statistics = self->statistics;
    statistics.load_percent_peak = 100.0 * (double)self->window_busy_peak_ns / (double)LOAD_WINDOW_NS;
    return statistics;
}
