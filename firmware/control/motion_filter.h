/* Velocity and acceleration of a quantity with three components from noisy samples at irregular times: the
 * fading-memory polynomial filter of third order (N. Morrison, "Introduction to Sequential Smoothing and Prediction",
 * 1969), that is, a critically damped alpha-beta-gamma filter. How long its memory is follows from the samples, so that
 * no tracker needs tuning:
 *
 *   noise   by the second differences of the innovations, which motion hardly changes;
 *   trend   the innovations averaged over the memory: as large as the noise makes it while the filter follows, larger
 * when the motion is faster than the memory is short; memory  shortens at once, in inverse proportion to the trend's
 * square beyond what noise explains; otherwise it grows again with MOTION_FILTER_SETTLE_S. */
#ifndef COMANIP_MOTION_FILTER_H
#define COMANIP_MOTION_FILTER_H

#include "../maths/dual_quaternion.h"
#include "../maths/float_bits.h"

/* The shortest memory, in motion, at the scale's noise and 4 ms between samples; it grows with the eighth root of the
 * noise's variance times the interval (a Kalman filter's for white jerk with the sixth; recordings ask for less), and
 * shrinks in very fast motion. */
#define MOTION_FILTER_MEMORY_S 0.038f
/* The longest memory, at rest, in shortest ones. */
#define MOTION_FILTER_REST_RATIO 2.8f
#define MOTION_FILTER_SETTLE_S 1.0f
/* Without innovations the acceleration fades with this time constant. */
#define MOTION_FILTER_ACCELERATION_S 0.15f
/* So far ahead it is counted on. Further, it would magnify a hand that shakes: at 4 Hz it turns round within 60 ms. */
#define MOTION_FILTER_ACCELERATION_AHEAD_S 0.03f

/* What is usual of the quantity, in its unit (m, rad). */
typedef struct {
    float noise_variance; /* per component: assumed at first; 0.2^2 to 100^2 times as much is believed */
    float velocity_max, acceleration_max; /* bounds of the estimates' magnitudes, in unit/s and unit/s^2 */
} motion_filter_scale_t;

typedef struct {
    vector3_t velocity, acceleration; /* at the newest sample */
    vector3_t innovation;             /* of the newest sample */
    vector3_t innovation_change;      /* from the sample before */
    vector3_t trend;
    float noise_variance; /* per component */
    float noise_time_s;   /* that it has been measured for, up to NOISE_S of motion_filter.c */
    float memory_s;
} motion_filter_t;

/* At rest, of the usual noise. */
void motion_filter_init(motion_filter_t *self, const motion_filter_scale_t *scale);

/* At rest again; the noise stays measured. */
void motion_filter_restart(motion_filter_t *self);

/* A time after the newest sample, for as many filters as there are: the motion goes on with constant acceleration for
 * MOTION_FILTER_ACCELERATION_AHEAD_S, with constant velocity from then on. */
typedef struct {
    float ahead_s, accelerated_s;
    float curve_s2; /* of the acceleration, in the displacement */
} motion_filter_ahead_t;

static inline motion_filter_ahead_t motion_filter_ahead(float ahead_s) {
    const bool is_accelerated = float_is_below(ahead_s, MOTION_FILTER_ACCELERATION_AHEAD_S);
    const float accelerated_s = is_accelerated ? ahead_s : MOTION_FILTER_ACCELERATION_AHEAD_S;
    return (motion_filter_ahead_t){ahead_s, accelerated_s, accelerated_s * (ahead_s - 0.5f * accelerated_s)};
}

/* From the newest sample until then; and the velocity then. */
static inline vector3_t motion_filter_displacement(const motion_filter_t *self, const motion_filter_ahead_t *then) {
    return vector3_add(vector3_scale(self->velocity, then->ahead_s), vector3_scale(self->acceleration, then->curve_s2));
}
static inline vector3_t motion_filter_velocity(const motion_filter_t *self, const motion_filter_ahead_t *then) {
    return vector3_add(self->velocity, vector3_scale(self->acceleration, then->accelerated_s));
}

/* Takes a sample, after the last by interval->ahead_s > 0. innovation: the sample less where displacement(interval)
 * leads. Returns what of the innovation is to be added to there: the filter keeps no position, so that a rotation may
 * be one. */
vector3_t motion_filter_update(motion_filter_t *self, const motion_filter_scale_t *scale, vector3_t innovation,
                               const motion_filter_ahead_t *interval);

#endif
