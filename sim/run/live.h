/* Options for watching a run, by pacing it to real time and by publishing it on a hub. Neither changes the results of
 * the run. */
#ifndef COMANIP_SIM_LIVE_H
#define COMANIP_SIM_LIVE_H

#include <stdbool.h>
#include <stddef.h>

#include "../bus/hub_publisher.h"
#include "../bus/real_time.h"
#include "../world/world.h"

typedef struct {
    const options_t *options;
    real_time_t real_time;
    hub_publisher_t hub;
} live_t;

/* Applies the world's options and prints how to listen. Call it just before the run. Returns false on failure, with one
 * line in `error`. */
bool live_open(live_t *self, world_t *world, char error[], size_t error_size);

/* Closes the hub and prints lost frames and lateness. */
void live_close(live_t *self);

#endif
