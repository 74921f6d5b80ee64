/* Implements bus.h on a real bus in real time: frames of the nodes are sent through a socket, and frames from the
 * socket are delivered to the nodes. The real bus arbitrates and determines the frame durations. A program links
 * live_bus.c in place of bus.c.
 *
 * Time is wall time since live_bus_start(), divided by the time scale. bus_run_until() returns at the given time and,
 * until then, delivers each frame as it arrives. The kernel echoes the nodes' own frames, which are then delivered in
 * bus order and with the kernel's timestamps. A hub does not echo them, so they are delivered when they are sent. A run
 * that is late catches up tick by tick, and counts the ticks that are more than one tick late. If the run is more than
 * 200 ms late, its clock is set back instead. */
#ifndef COMANIP_SIM_LIVE_BUS_H
#define COMANIP_SIM_LIVE_BUS_H

#include <signal.h>
#include <stddef.h>

#include "bus.h"

typedef struct {
    uint32_t slow;       /* time scale */
    uint64_t overruns;   /* ticks that ended more than one tick late */
    int64_t late_max_ns; /* largest lateness, measured on the run's clock */
    int64_t set_back_ns; /* total by which the run's clock was set back */
} live_bus_timing_t;

/* Opens the bus `can`. program: name of this program, for messages. slow: time scale, as in hal/linux/pace.h. Returns
 * NULL on failure, with one line in `error`. */
bus_t *live_bus_create(const char *program, const char *can, can_profile_t profile, uint32_t slow, char error[],
                       size_t error_size);

/* Waits for a frame with this id, which becomes the first frame of the run, in tick 0. Returns false if interrupted. */
bool live_bus_start(bus_t *self, uint16_t id, const volatile sig_atomic_t *interrupted);

live_bus_timing_t live_bus_timing(const bus_t *self);

#endif
