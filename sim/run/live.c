#include "live.h"

#include <inttypes.h>
#include <stdio.h>

#define LATE_TOLERATED_NS 10000000

static void print_how_to_listen(const live_t *self) {
    (void)printf("the bus is live on %s hub %s; to listen in another terminal: make candump, or build/host/with-can "
                 "candump -ta %s\n",
                 self->hub.hub > 0 ? "its own" : "the running", self->options->hub, self->options->hub);
    if (!self->hub.is_exclusive) {
        (void)printf("clients of this hub also receive each other's frames; the simulator receives none of them\n");
    }
    (void)fflush(stdout);
}

bool live_open(live_t *self, world_t *world, char error[], size_t error_size) {
    *self = (live_t){.options = world->options};
    if (self->options->hub != NULL) {
        if (!hub_publisher_open(&self->hub, self->options->hub, error, error_size)) {
            return false;
        }
        if (!self->options->quiet) {
            print_how_to_listen(self);
        }
    }
    if (self->options->real_time) {
        real_time_start(&self->real_time);
        bus_listen(world->bus, real_time_wait, &self->real_time);
    }
    if (self->options->hub != NULL) {
        bus_listen(world->bus, hub_publisher_send, &self->hub);
    }
    return true;
}

void live_close(live_t *self) {
    if (self->options->hub != NULL) {
        hub_publisher_close(&self->hub);
        if (self->hub.lost > 0) {
            (void)fprintf(stderr, "comanip-sim: %" PRIu64 " frames were not published on the hub\n", self->hub.lost);
        }
    }
    if (self->real_time.latest_ns > LATE_TOLERATED_NS && !self->options->quiet) {
        (void)printf("the run was up to %.3f s behind real time\n", (double)self->real_time.latest_ns * 1e-9);
    }
}
