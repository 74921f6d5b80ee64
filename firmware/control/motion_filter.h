/* Estimates the velocity and acceleration of a quantity with three components from noisy samples taken at irregular
 * times. This is the fading-memory polynomial filter of third order (N. Morrison, "Introduction to Sequential Smoothing
 * and Prediction", 1969), which is a critically damped alpha-beta-gamma filter. Its memory adapts to the samples, so
 * that no tracker needs tuning:
 *
 *   noise   is measured by the second differences of the innovations, on which motion has little influence.
 *   trend   is the mean of the innovations over the memory. While the filter follows the motion, the trend is as
 *           large as the noise; it is larger if the motion is too fast for the memory.
 *   memory  shortens at once if the trend exceeds the noise, in inverse proportion to the trend's square; otherwise it
 *           grows with the time constant MOTION_FILTER_SETTLE_S. */
#ifndef COMANIP_MOTION_FILTER_H
#define COMANIP_MOTION_FILTER_H

#include "../maths/dual_quaternion.h"
#include "../maths/float_bits.h"

/* The shortest memory, which is used during motion. The value applies to the noise variance of the scale and a sample
 * interval of 4 ms. The shortest memory grows with the eighth root of noise variance times interval, and shrinks in
 * very fast motion. (The memory of a Kalman filter for white jerk would grow with the sixth root, but recorded hand
 * motions are predicted better with less growth.) */
#define MOTION_FILTER_MEMORY_S 0.038f
/* Ratio of the longest memory, which is used at rest, to the shortest. */
#define MOTION_FILTER_REST_RATIO 2.8f
#define MOTION_FILTER_SETTLE_S 1.0f
/* Without innovations the acceleration decays with this time constant. */
#define MOTION_FILTER_ACCELERATION_S 0.15f
/* Extrapolation uses the acceleration only for this time. A longer time would amplify tremor: at 4 Hz, the acceleration
 * changes sign within 60 ms. */
#define MOTION_FILTER_ACCELERATION_AHEAD_S 0.03f

/* Typical values of the quantity, in its own unit (m or rad). */
typedef struct {
    float noise_variance;                 /* initial estimate, per component; later ones: 0.2^2 to 100^2 times this */
    float velocity_max, acceleration_max; /* upper bounds of the estimates' magnitudes, in unit/s and unit/s^2 */
} motion_filter_scale_t;

typedef struct {
    vector3_t velocity, acceleration; /* estimates at the newest sample */
    vector3_t innovation;             /* innovation of the newest sample */
    vector3_t innovation_change;      /* change of the innovation from that of the previous sample */
    vector3_t trend;
    float noise_variance; /* measured noise, per component */
    float noise_time_s;   /* time over which the noise has been measured, up to NOISE_S of motion_filter.c */
    float memory_s;
} motion_filter_t;

/* Initialises the estimates to rest, with the typical noise. */
void motion_filter_init(motion_filter_t *self, const motion_filter_scale_t *scale);

/* Resets the estimates to rest, but keeps the measured noise. */
void motion_filter_restart(motion_filter_t *self);

/* A point in time after the newest sample; several filters can share it. The motion is extrapolated with constant
 * acceleration for MOTION_FILTER_ACCELERATION_AHEAD_S and with constant velocity afterwards. */
typedef struct {
    float ahead_s, accelerated_s;
    float curve_s2; /* factor by which the acceleration contributes to the displacement */
} motion_filter_ahead_t;

static inline motion_filter_ahead_t motion_filter_ahead(float ahead_s) {
    const bool is_accelerated = float_is_below(ahead_s, MOTION_FILTER_ACCELERATION_AHEAD_S);
    const float accelerated_s = is_accelerated ? ahead_s : MOTION_FILTER_ACCELERATION_AHEAD_S;
    return (motion_filter_ahead_t){ahead_s, accelerated_s, accelerated_s * (ahead_s - 0.5f * accelerated_s)};
}

/* Return the displacement from the newest sample to `then`, and the velocity at `then`. */
static inline vector3_t motion_filter_displacement(const motion_filter_t *self, const motion_filter_ahead_t *then) {
    return vector3_add(vector3_scale(self->velocity, then->ahead_s), vector3_scale(self->acceleration, then->curve_s2));
}
static inline vector3_t motion_filter_velocity(const motion_filter_t *self, const motion_filter_ahead_t *then) {
    return vector3_add(self->velocity, vector3_scale(self->acceleration, then->accelerated_s));
}

/* Takes a sample that was captured interval->ahead_s seconds (> 0) after the last one. innovation: the sample minus the
 * position predicted by motion_filter_displacement(interval). Returns the correction of that prediction. The filter
 * stores no position, so that it can also be used for rotations. */
vector3_t motion_filter_update(motion_filter_t *self, const motion_filter_scale_t *scale, vector3_t innovation,
                               const motion_filter_ahead_t *interval);

#endif
