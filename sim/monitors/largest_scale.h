/* The largest motion scale at which the arm could have reached every target while a recording was played. The target's
 * way since the recording began is taken to be proportional to the scale, and what came before to stay as it was. That
 * is exact for `teleop`; where a task has a lever between the hands, a turn of the wrist adds to the way whatever the
 * scale. */
#ifndef COMANIP_SIM_LARGEST_SCALE_H
#define COMANIP_SIM_LARGEST_SCALE_H

#include <stdbool.h>
#include <stddef.h>

#include "observer.h"

typedef struct {
    double target_m[3]; /* at the scale in force, in torso axes */
    double way_m[3];    /* of it, since the recording began */
} scaled_target_t;

typedef struct {
    bool has_reference;
    double reference_m[3]; /* the target when the recording began */
    scaled_target_t *target;
    size_t count, capacity;
    bool out_of_memory; /* the later targets are missing */
} largest_scale_t;

void largest_scale_init(largest_scale_t *self);
void largest_scale_free(largest_scale_t *self);

/* One finished tick while the recording is played. */
void largest_scale_sample(largest_scale_t *self, const tick_record_t *tick);

/* The recording is not played. */
void largest_scale_pause(largest_scale_t *self);

/* The largest number of two significant digits, at most `scale` (the one in force, above 0) and at least `minimum`, at
 * which all targets are in reach. 0: there is none, or no target was sampled, or memory ran out. */
double largest_scale(const largest_scale_t *self, double scale, double minimum);

#endif
