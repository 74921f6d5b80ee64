#include "live_bus.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/select.h>

#include "../../hal/common/frame_time.h"
#include "../../hal/linux/can_socket.h"
#include "../../hal/linux/pace.h"

#define LOAD_WINDOW_NS INT64_C(10000000)
#define SET_BACK_NS INT64_C(200000000)
#define QUEUE_FRAMES (BUS_MAX_NODES * BUS_QUEUE_FRAMES)
#define IDS 0x800
#define NO_NODE (-1)

typedef struct {
    bus_handler_t handler;
    void *context;
} receiver_t;

typedef struct {
    can_frame_t frame;
    int64_t ready_ns;
} pending_t;

struct bus {
    can_profile_t profile;
    can_socket_t can;
    pace_t pace;
    int64_t start_unix_ns; /* Unix time at time 0; a multiple of the pace's tick */
    int node_count, listener_count;
    receiver_t node[BUS_MAX_NODES], listener[BUS_MAX_NODES];
    int sender[IDS]; /* index of the node that sends each id */

    int pending_count;
    pending_t pending[QUEUE_FRAMES]; /* sorted by ready_ns, then by id */

    bool has_next; /* `next` has been received but not yet delivered */
    can_frame_t next;
    can_reception_t next_reception;

    int64_t window, window_busy_ns, window_busy_peak_ns;
    bus_statistics_t statistics;
    live_bus_timing_t timing;
};

/* ---- time */

static int64_t time_of(const bus_t *self, int64_t unix_ns) {
    return (unix_ns - self->start_unix_ns) / self->pace.slow;
}

static int64_t now_ns(const bus_t *self) {
    return time_of(self, pace_now_unix_ns(&self->pace));
}

int64_t bus_epoch_ns(const bus_t *self) {
    return self->start_unix_ns / self->pace.slow;
}

/* Records how late the run is, and sets its clock back if the run is more than SET_BACK_NS late. Called before the tick
 * that ends at time_ns. */
static void note_lateness(bus_t *self, int64_t time_ns) {
    (void)pace_find_step(&self->pace);
    const int64_t late_ns = now_ns(self) - time_ns;
    if (late_ns > self->timing.late_max_ns) {
        self->timing.late_max_ns = late_ns;
    }
    if (late_ns > PACE_TICK_NS) {
        self->timing.overruns++;
    }
    if (late_ns > SET_BACK_NS) {
        const int64_t ticks = late_ns / PACE_TICK_NS;
        self->start_unix_ns += ticks * PACE_TICK_NS * self->pace.slow;
        self->timing.set_back_ns += ticks * PACE_TICK_NS;
    }
}

static void wait_until(bus_t *self, int64_t time_ns) {
    int64_t left_ns = (time_ns - now_ns(self)) * self->pace.slow;
    left_ns = left_ns > 0 ? left_ns : 0;
    const struct timespec timeout = {.tv_sec = (time_t)(left_ns / 1000000000), .tv_nsec = (long)(left_ns % 1000000000)};
    fd_set readable;
    FD_ZERO(&readable);
    if (self->can.fd >= 0) {
        FD_SET(self->can.fd, &readable);
    }
    (void)pselect(self->can.fd + 1, &readable, NULL, NULL, &timeout, NULL); /* a signal may end the wait early */
}

/* ---- frames */

static void count_load(bus_t *self, const can_frame_t *frame, int64_t end_ns) {
    const int64_t duration_ns = frame_time_ns(frame);
    const int64_t window = end_ns / LOAD_WINDOW_NS;
    self->statistics.frames++;
    if (duration_ns < 0) {
        return; /* a frame from another device, with a length that CAN FD does not allow */
    }
    self->window_busy_ns = window == self->window ? self->window_busy_ns + duration_ns : duration_ns;
    self->window = window;
    self->statistics.busy_ns += duration_ns;
    if (self->window_busy_ns > self->window_busy_peak_ns) {
        self->window_busy_peak_ns = self->window_busy_ns;
    }
}

static void deliver(bus_t *self, can_frame_t *frame, int64_t unix_ns, int sender) {
    const int64_t end_ns = time_of(self, unix_ns);
    frame->timestamp_us = (uint32_t)(end_ns / 1000);
    count_load(self, frame, end_ns);
    for (int i = 0; i < self->listener_count; i++) {
        self->listener[i].handler(self->listener[i].context, frame, end_ns);
    }
    for (int i = 0; i < self->node_count; i++) {
        if (i != sender && self->node[i].handler != NULL) {
            self->node[i].handler(self->node[i].context, frame, end_ns);
        }
    }
}

/* Fills `next`. Returns false if no frame has arrived. */
static bool fetch(bus_t *self) {
    if (!self->has_next && can_socket_receive(&self->can, &self->next, &self->next_reception)) {
        can_reception_t *reception = &self->next_reception;
        self->has_next = true;
        reception->unix_ns = reception->unix_ns != 0 ? pace_stamp_unix_ns(&self->pace, reception->unix_ns)
                                                     : pace_now_unix_ns(&self->pace);
    }
    return self->has_next;
}

/* Delivers the frames that arrived up to time_ns. If the run is late, frames of later ticks have arrived as well; they
 * are left for those ticks. */
static void receive_until(bus_t *self, int64_t time_ns) {
    while (fetch(self) && time_of(self, self->next_reception.unix_ns) <= time_ns) {
        self->has_next = false;
        deliver(self, &self->next, self->next_reception.unix_ns,
                self->next_reception.own ? self->sender[self->next.id] : NO_NODE);
    }
}

static void send_until(bus_t *self, int64_t time_ns) {
    while (self->pending_count > 0 && self->pending[0].ready_ns <= time_ns) {
        pending_t pending = self->pending[0];
        self->pending_count--;
        memmove(&self->pending[0], &self->pending[1], (size_t)self->pending_count * sizeof pending);
        const bool is_echoed = self->can.hub_path[0] == '\0';
        if (can_socket_send(&self->can, &pending.frame) && !is_echoed) {
            deliver(self, &pending.frame, pace_now_unix_ns(&self->pace), self->sender[pending.frame.id]);
        }
    }
}

/* ---- live_bus.h */

bus_t *live_bus_create(const char *program, const char *can, can_profile_t profile, uint32_t slow, char error[],
                       size_t error_size) {
    bus_t *self = calloc(1, sizeof *self);
    const can_selection_t everything = {.own = true, .classic = profile == CAN_PROFILE_CLASSIC};
    if (self == NULL) {
        (void)snprintf(error, error_size, "not enough memory for the bus");
        return NULL;
    }
    if (!can_socket_open(&self->can, program, can, &everything, error, error_size)) {
        free(self);
        return NULL;
    }
    self->profile = profile;
    pace_init(&self->pace, slow);
    self->timing = (live_bus_timing_t){.slow = slow};
    return self;
}

bool live_bus_start(bus_t *self, uint16_t id, const volatile sig_atomic_t *interrupted) {
    while (fetch(self)) { /* discard frames that arrived while the world was being built */
        self->has_next = false;
    }
    while (!(fetch(self) && self->next.id == id)) {
        self->has_next = false;
        if (*interrupted != 0) {
            return false;
        }
        wait_until(self, now_ns(self) + PACE_TICK_NS);
    }
    const int64_t period_ns = PACE_TICK_NS * self->pace.slow;
    self->start_unix_ns = self->next_reception.unix_ns / period_ns * period_ns;
    return true;
}

live_bus_timing_t live_bus_timing(const bus_t *self) {
    return self->timing;
}

/* ---- bus.h */

void bus_destroy(bus_t *self) {
    if (self != NULL) {
        can_socket_report(&self->can);
        can_socket_close(&self->can);
        free(self);
    }
}

can_profile_t bus_profile(const bus_t *self) {
    return self->profile;
}

int bus_attach(bus_t *self, bus_handler_t handler, void *context) {
    assert(self->node_count < BUS_MAX_NODES);
    self->node[self->node_count] = (receiver_t){.handler = handler, .context = context};
    return self->node_count++;
}

void bus_listen(bus_t *self, bus_handler_t handler, void *context) {
    assert(self->listener_count < BUS_MAX_NODES);
    self->listener[self->listener_count++] = (receiver_t){.handler = handler, .context = context};
}

bool bus_send(bus_t *self, int node, const can_frame_t *frame, int64_t ready_ns) {
    assert(node >= 0 && node < self->node_count && frame->id < IDS);
    if (self->pending_count == QUEUE_FRAMES) {
        self->statistics.dropped++;
        return false;
    }
    int index = self->pending_count++;
    for (; index > 0; index--) {
        const pending_t *before = &self->pending[index - 1];
        if (before->ready_ns < ready_ns || (before->ready_ns == ready_ns && before->frame.id <= frame->id)) {
            break;
        }
        self->pending[index] = *before;
    }
    self->pending[index] = (pending_t){.frame = *frame, .ready_ns = ready_ns};
    self->sender[frame->id] = node;
    return true;
}

void bus_run_until(bus_t *self, int64_t time_ns) {
    note_lateness(self, time_ns);
    for (;;) {
        const int64_t now = now_ns(self);
        const bool is_over = now >= time_ns;
        receive_until(self, time_ns);
        send_until(self, is_over ? time_ns : now);
        if (is_over) {
            return;
        }
        const bool has_pending = self->pending_count > 0 && self->pending[0].ready_ns < time_ns;
        wait_until(self, has_pending ? self->pending[0].ready_ns : time_ns);
    }
}

bus_statistics_t bus_statistics(const bus_t *self) {
    bus_statistics_t statistics = self->statistics;
    statistics.dropped += self->can.counters.send_drops + self->can.counters.receive_drops;
    statistics.load_percent_peak = 100.0 * (double)self->window_busy_peak_ns / (double)LOAD_WINDOW_NS;
    return statistics;
}
