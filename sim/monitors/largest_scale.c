#include "largest_scale.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reach.h"

#define DISPLACEMENT_MIN_M REACH_TOLERANCE_M /* smallest displacement of the target between two samples */
#define FIRST_CAPACITY 1024
#define ROUNDING 1e-6 /* relative rounding error of a float32 parameter; makes 0.29f count as 0.29 */

void largest_scale_init(largest_scale_t *self) {
    memset(self, 0, sizeof *self);
}

void largest_scale_free(largest_scale_t *self) {
    free(self->target);
}

static double distance_m(const double a[3], const double b[3]) {
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

static bool make_room(largest_scale_t *self) {
    if (self->count < self->capacity) {
        return true;
    }
    const size_t capacity = self->capacity == 0 ? FIRST_CAPACITY : 2 * self->capacity;
    scaled_target_t *target = realloc(self->target, capacity * sizeof *target);
    if (target == NULL) {
        self->out_of_memory = true;
        return false;
    }
    self->target = target;
    self->capacity = capacity;
    return true;
}

void largest_scale_sample(largest_scale_t *self, const tick_record_t *tick) {
    const double *target_m = tick->target.position_m;
    if (!tick->has_target) {
        return;
    }
    if (!self->has_reference) {
        memcpy(self->reference_m, target_m, sizeof self->reference_m);
        self->has_reference = true;
    } else if (self->count > 0 && distance_m(self->target[self->count - 1].target_m, target_m) < DISPLACEMENT_MIN_M) {
        return;
    }
    if (!make_room(self)) {
        return;
    }
    scaled_target_t *new = &self->target[self->count++];
    for (int k = 0; k < 3; k++) {
        new->target_m[k] = target_m[k];
        new->displacement_m[k] = target_m[k] - self->reference_m[k];
    }
}

void largest_scale_pause(largest_scale_t *self) {
    self->has_reference = false;
}

/* ---- the search */

/* A number with two significant digits: 10 to 99, times a power of ten. */
typedef struct {
    int digits;
    int exponent;
} two_digits_t;

static double value(two_digits_t number) {
    return number.exponent >= 0 ? number.digits * pow(10.0, number.exponent)
                                : number.digits / pow(10.0, -number.exponent);
}

static two_digits_t rounded_down(double scale) {
    const int exponent = (int)floor(log10(scale * (1.0 + ROUNDING))) - 1;
    return (two_digits_t){(int)floor(scale * (1.0 + ROUNDING) * pow(10.0, -exponent)), exponent};
}

static two_digits_t next_lower(two_digits_t number) {
    return number.digits > 10 ? (two_digits_t){number.digits - 1, number.exponent}
                              : (two_digits_t){99, number.exponent - 1};
}

static bool is_reached(reach_t *reach, const scaled_target_t *target, double ratio) {
    double target_m[3], posture_rad[ROBOT_JOINTS];
    for (int k = 0; k < 3; k++) {
        target_m[k] = target->target_m[k] + (ratio - 1.0) * target->displacement_m[k];
    }
    memcpy(posture_rad, reach->position_rad, sizeof posture_rad);
    return reach_contains(reach, target_m, posture_rad);
}

/* A candidate is rejected only if some target is out of reach, and accepted only if a whole pass over the targets finds
 * none out of reach. No valid scale is therefore skipped, even if a target leaves the workspace and re-enters it as the
 * scale decreases. */
double largest_scale(const largest_scale_t *self, double scale, double minimum) {
    reach_t reach;
    reach_init(&reach);
    two_digits_t candidate = rounded_down(scale);
    const double lowest = minimum * (1.0 - ROUNDING);
    size_t reached = 0; /* consecutive targets in reach at this candidate */
    for (size_t i = 0; !self->out_of_memory && reached < self->count; i = (i + 1) % self->count) {
        reached++;
        while (!is_reached(&reach, &self->target[i], value(candidate) / scale)) {
            candidate = next_lower(candidate);
            reached = 1;
            if (value(candidate) < lowest) {
                return 0.0;
            }
        }
    }
    return self->count > 0 && !self->out_of_memory ? value(candidate) : 0.0;
}
