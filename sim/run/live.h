/* A run that people watch while it goes on: paced by real time, shown on a hub. Neither changes what happens in it. */
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

/* Does what the world's options ask for, and says how to listen. Call it just before the run. On failure false, and one
 * line in `error`. */
bool live_open(live_t *self, world_t *world, char error[], size_t error_size);

/* Says how well it went. */
void live_close(live_t *self);

#endif
