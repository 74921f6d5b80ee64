/* bus.h on a real bus, in real time: what the nodes send goes out through a socket, and what arrives there is handed to
 * them; arbitration and the frames' durations are the real bus's own. Linked in place of bus.c.
 *
 * Time is wall time since live_bus_start(), divided by the time scale. bus_run_until() waits for it, and hands each
 * frame over as it arrives. Frames are listened to as they come back from the bus, in its order and with the kernel's
 * time stamps; a hub sends none back, so there the nodes' own are listened to as they are sent. A run that is late
 * catches up tick by tick, which is counted; later than 200 ms, it lets the clock go. */
#ifndef COMANIP_SIM_LIVE_BUS_H
#define COMANIP_SIM_LIVE_BUS_H

#include <signal.h>
#include <stddef.h>

#include "bus.h"

typedef struct {
    uint32_t slow;
    uint64_t overruns;   /* ticks that ended more than a tick too late */
    int64_t late_max_ns; /* by the run's clock */
    int64_t let_go_ns;   /* by which the run's clock was put back in all */
} live_bus_timing_t;

/* program: its name, for what is told. slow: as in hal/linux/pace.h. On failure NULL, and one line in `error`. */
bus_t *live_bus_create(const char *program, const char *can, can_profile_t profile, uint32_t slow, char error[],
                       size_t error_size);

/* Waits for a frame of this id, which then is the first one, in tick 0. False: interrupted. */
bool live_bus_start(bus_t *self, uint16_t id, const volatile sig_atomic_t *interrupted);

live_bus_timing_t live_bus_timing(const bus_t *self);

#endif
