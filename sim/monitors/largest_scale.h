/* Finds the largest motion scale at which the arm could have reached every target of a played recording. The target's
 * displacement since the start of the recording is assumed to be proportional to the scale; the target's start position
 * is assumed not to depend on the scale. This is exact for `teleop`. It is approximate for a task with a lever between
 * the hands, because rotations of the wrist then add a displacement that does not depend on the scale. */
#ifndef COMANIP_SIM_LARGEST_SCALE_H
#define COMANIP_SIM_LARGEST_SCALE_H

#include <stdbool.h>
#include <stddef.h>

#include "observer.h"

typedef struct {
    double target_m[3];       /* target at the current scale, in torso axes */
    double displacement_m[3]; /* displacement since the start of the recording */
} scaled_target_t;

typedef struct {
    bool has_reference;
    double reference_m[3]; /* the target at the start of the recording */
    scaled_target_t *target;
    size_t count, capacity;
    bool out_of_memory; /* later targets are missing */
} largest_scale_t;

void largest_scale_init(largest_scale_t *self);
void largest_scale_free(largest_scale_t *self);

/* Adds a finished tick in which the recording is played. */
void largest_scale_sample(largest_scale_t *self, const tick_record_t *tick);

/* Must be called in every tick in which the recording is not played. The next sample then becomes the reference. */
void largest_scale_pause(largest_scale_t *self);

/* Returns the largest scale with two significant digits, from `minimum` to `scale` (the current scale, above 0), at
 * which all targets are in reach. Returns 0 if no scale qualifies, if no target was sampled, or if memory ran out. */
double largest_scale(const largest_scale_t *self, double scale, double minimum);

#endif
