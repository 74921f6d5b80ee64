/* Lets a user watch a run: --real-time paces the run to real time, and --hub publishes its frames on a hub. Neither
 * option changes the results of the run. */
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

/* Applies the two options and prints how to listen to the bus. Call it just before the run. Returns false on failure,
 * with one line in `error`. */
bool live_open(live_t *self, world_t *world, char error[], size_t error_size);

/* Leaves the hub. Prints a line if frames were not published, and a line if the run was late. */
void live_close(live_t *self);

#endif
