/* Fading-memory filter: see motion_filter.h. */
#include "motion_filter.h"

/* The noise is averaged over NOISE_S or, shortly after the start, over the elapsed time plus NOISE_TIME_MIN_S. */
#define NOISE_S 1.0f
#define NOISE_TIME_MIN_S 0.03f

/* If the trend's square exceeds its expected value by more than this factor, the shortest memory is divided by the
 * eighth root of the excess. */
#define TREND_FAST 10.0f

#define NOISE_MIN 0.2f /* in units of the scale's standard deviation */
#define NOISE_MAX 100.0f
/* Upper limit of a single measurement of the noise variance, relative to the present estimate, so that an outlier does
 * not count as noise. */
#define OUTLIER_VARIANCES 9.0f

#define INTERVAL_S 0.004f /* sample interval for which MOTION_FILTER_MEMORY_S was tuned */

void motion_filter_init(motion_filter_t *self, const motion_filter_scale_t *scale) {
    *self = (motion_filter_t){
        .noise_variance = scale->noise_variance,
        .noise_time_s = NOISE_TIME_MIN_S,
        .memory_s = MOTION_FILTER_MEMORY_S,
    };
}

void motion_filter_restart(motion_filter_t *self) {
    *self = (motion_filter_t){
        .noise_variance = self->noise_variance,
        .noise_time_s = self->noise_time_s,
        .memory_s = MOTION_FILTER_MEMORY_S,
    };
}

/* kept: the share of the past, exp(-x), that is kept after a time x >= 0 in units of the memory. forgotten: 1 minus
 * that share. The exponential is approximated by 1 / (1 + x + x^2/2 + x^3/6), which decreases monotonically from 1 to 0
 * and exceeds exp(-x) by at most 0.03 (at x = 2.9; by 2e-4 at x = 0.3). */
typedef struct {
    float kept, forgotten;
} fading_t;

static fading_t fading(float x) {
    const float growth = x * (1.0f + x * (0.5f + x * 0.16666667f));
    const float kept = 1.0f / (1.0f + growth);
    return (fading_t){kept, growth * kept};
}

static float cube(float x) {
    return x * x * x;
}

/* Returns x clamped to min..max. None of the three may be negative. */
static float clamp(float x, float min, float max) {
    return float_is_below(x, min) ? min : float_smaller(x, max);
}

/* Returns x^(1/8) of a normal number, within 0.4 %. Without a floating-point unit, three square roots would cost twice
 * as much. The bits of a float approximate its logarithm, so dividing them by 8 and adding a constant yields a guess
 * within 4 %; one Newton step follows. */
static float eighth_root(float x) {
    const uint32_t guess_bits = (float_bits(x) >> 3) + 0x378B6000u;
    float guess;
    memcpy(&guess, &guess_bits, sizeof guess);
    const float square = guess * guess;
    return 0.875f * guess + 0.125f * x / (square * square * square * guess);
}

static vector3_t shorten(vector3_t v, float length_max) {
    const float square = vector3_dot(v, v);
    return float_is_below(length_max * length_max, square) ? vector3_scale(v, length_max / __builtin_sqrtf(square)) : v;
}

/* Updates the measured noise. If the noise is white, the innovations are white too, and their variance is noise /
 * kept^3. */
static void measure_noise(motion_filter_t *self, const motion_filter_scale_t *scale, vector3_t innovation,
                          float interval_s, float kept) {
    const vector3_t change = vector3_add(innovation, vector3_scale(self->innovation, -1.0f));
    const vector3_t bend = vector3_add(change, vector3_scale(self->innovation_change, -1.0f));
    self->innovation_change = change;
    const float measured =
        cube(kept) * vector3_dot(bend, bend) * (1.0f / 18.0f); /* three components; 1 + 4 + 1 variances each */
    const float believed = float_smaller(measured, OUTLIER_VARIANCES * self->noise_variance);
    self->noise_time_s = float_smaller(self->noise_time_s + interval_s, NOISE_S);
    const float variance = self->noise_variance + (believed - self->noise_variance) * (interval_s / self->noise_time_s);
    self->noise_variance =
        clamp(variance, NOISE_MIN * NOISE_MIN * scale->noise_variance, NOISE_MAX * NOISE_MAX * scale->noise_variance);
}

static void adapt_memory(motion_filter_t *self, const motion_filter_scale_t *scale, vector3_t innovation,
                         float interval_s, fading_t past) {
    const vector3_t kept = vector3_scale(self->trend, past.kept);
    self->trend = vector3_add(kept, vector3_scale(innovation, past.forgotten));
    const float trend_square = vector3_dot(self->trend, self->trend);
    const float expected_square = 3.0f * self->noise_variance * past.forgotten / (cube(past.kept) * (1.0f + past.kept));

    float noise = self->noise_variance / scale->noise_variance * (interval_s * (1.0f / INTERVAL_S));
    const float slow_square = TREND_FAST * expected_square;
    if (float_is_below(slow_square, trend_square)) {
        noise *= slow_square / trend_square;
    }
    const float shortest_s = MOTION_FILTER_MEMORY_S * eighth_root(noise);
    const float longest_s = MOTION_FILTER_REST_RATIO * shortest_s;
    self->memory_s += (longest_s - self->memory_s) * (interval_s / MOTION_FILTER_SETTLE_S);
    const float explained = longest_s * expected_square;
    if (float_is_below(explained, self->memory_s * trend_square)) {
        self->memory_s = explained / trend_square;
    }
    self->memory_s = clamp(self->memory_s, shortest_s, longest_s);
}

vector3_t motion_filter_update(motion_filter_t *self, const motion_filter_scale_t *scale, vector3_t innovation,
                               const motion_filter_ahead_t *interval) {
    const float interval_s = interval->ahead_s;
    const fading_t past = fading(interval_s / self->memory_s);
    measure_noise(self, scale, innovation, interval_s, past.kept);
    adapt_memory(self, scale, innovation, interval_s, past);
    self->innovation = innovation;

    const fading_t now = fading(interval_s / self->memory_s);
    const float forgotten_per_s = now.forgotten / interval_s;
    const float velocity_gain = 1.5f * (1.0f + now.kept) * now.forgotten * forgotten_per_s;
    const float acceleration_gain = now.forgotten * forgotten_per_s * forgotten_per_s;
    const float acceleration_kept = fading(interval_s / MOTION_FILTER_ACCELERATION_S).kept;
    const vector3_t velocity = motion_filter_velocity(self, interval);
    const vector3_t acceleration = vector3_scale(self->acceleration, acceleration_kept);
    self->velocity = shorten(vector3_add(velocity, vector3_scale(innovation, velocity_gain)), scale->velocity_max);
    self->acceleration =
        shorten(vector3_add(acceleration, vector3_scale(innovation, acceleration_gain)), scale->acceleration_max);
    return vector3_scale(innovation, now.forgotten * (1.0f + now.kept + now.kept * now.kept));
}
