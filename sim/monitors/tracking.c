#include "tracking.h"

#include <math.h>
#include <string.h>

#include "../common/rigid_pose.h"

#define POSITION_MARGIN_RAD (1.0 * ROBOT_RAD_PER_DEG) /* a joint this close to its limit counts as at its limit */
#define SETTLE_NS ((int64_t)(TRACKING_SETTLE_S * 1e9))
#define LIMIT_SHARE 0.9 /* a joint above this share of a speed limit counts as at the limit */

void tracking_init(tracking_t *self) {
    memset(self, 0, sizeof *self);
    reach_init(&self->reach);
    self->limited_ns = INT64_MIN / 2;
    self->no_target_ns = INT64_MIN / 2;
}

double tracking_distance_mm(const tick_record_t *tick) {
    const double *a = tick->hand_at_target.position_m, *b = tick->target.position_m;
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return 1e3 * sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

/* Returns true if some joint could not follow under any controller, because it is at its position limit, at its speed
 * limit, or too fast to stop within TRACKING_STOP_S at its acceleration limit. Speeds are averaged, because the
 * tracker's noise alone causes single fast ticks while the hand rests. The gains and weights of the control law are not
 * used, so that the controller cannot influence its own evaluation. */
static bool is_limited(tracking_t *self, const tick_record_t *tick, const float parameter[]) {
    const double speed_max_radps = fmin((double)parameter[PARAMETER_SPEED_FRACTION] * ROBOT_VELOCITY_MAX_RADPS,
                                        (double)parameter[PARAMETER_ACCELERATION_LIMIT_RADPS2] * TRACKING_STOP_S);
    bool limited = false;
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        double *mean_radps = &self->mean_velocity_radps[i];
        *mean_radps += ((double)tick->command.velocity_radps[i] - *mean_radps) / TRACKING_MEAN_TICKS;
        limited = limited || fabs(*mean_radps) > LIMIT_SHARE * speed_max_radps ||
                  tick->measured_rad[i] < robot_model_position_min_rad(i) + POSITION_MARGIN_RAD ||
                  tick->measured_rad[i] > robot_model_position_max_rad(i) - POSITION_MARGIN_RAD;
    }
    return limited;
}

static void add(tracking_sums_t *sums, tracking_error_t error) {
    sums->ticks++;
    sums->square_position_mm2 += error.position_mm * error.position_mm;
    sums->square_orientation_deg2 += error.orientation_deg * error.orientation_deg;
    sums->max_position_mm = fmax(sums->max_position_mm, error.position_mm);
    sums->max_orientation_deg = fmax(sums->max_orientation_deg, error.orientation_deg);
}

/* If the hand is fast, the error already grows some ticks before a joint reaches its limit. Errors are therefore
 * counted with a delay, and discarded if a joint reaches its limit in the meantime. */
static void add_followable(tracking_t *self, tracking_error_t error) {
    if (self->pending_count == TRACKING_LOOK_AHEAD) {
        add(&self->followable, self->pending[self->pending_first]);
        self->pending_first = (self->pending_first + 1) % TRACKING_LOOK_AHEAD;
        self->pending_count--;
    }
    self->pending[(self->pending_first + self->pending_count) % TRACKING_LOOK_AHEAD] = error;
    self->pending_count++;
}

static bool is_target_in_reach(tracking_t *self, const tick_record_t *tick) {
    if (self->ticks_to_next_search == 0) {
        self->in_reach = reach_contains(&self->reach, tick->target.position_m, tick->measured_rad);
        self->ticks_to_next_search = TRACKING_REACH_TICKS;
    }
    self->ticks_to_next_search--;
    return self->in_reach;
}

static bool is_settled(const tracking_t *self, const tick_record_t *tick) {
    return tick->time_ns - self->no_target_ns > SETTLE_NS;
}

bool tracking_is_followable(const tracking_t *self, const tick_record_t *tick) {
    return tick->has_target && self->in_reach && is_settled(self, tick) && tick->time_ns - self->limited_ns > SETTLE_NS;
}

void tracking_sample(tracking_t *self, const tick_record_t *tick, const float parameter[]) {
    if (tick->has_command && is_limited(self, tick, parameter)) {
        self->limited_ns = tick->time_ns;
        self->pending_count = 0;
    }
    self->cooperating_ticks += tick->mode == MODE_COOPERATING;
    if (!tick->has_target) {
        self->no_target_ns = tick->time_ns;
        return;
    }
    self->settled_ticks += is_settled(self, tick);
    const bool in_reach = is_target_in_reach(self, tick);
    const tracking_error_t error = {
        .position_mm = tracking_distance_mm(tick),
        .orientation_deg =
            rotation_angle_between(tick->hand_at_target.rotation, tick->target.rotation) / ROBOT_RAD_PER_DEG,
    };
    add(&self->all, error);
    self->out_of_reach_ticks += !in_reach;
    if (tracking_is_followable(self, tick)) {
        add_followable(self, error);
    }
}

double tracking_rms_position_mm(const tracking_sums_t *sums) {
    return sums->ticks > 0 ? sqrt(sums->square_position_mm2 / (double)sums->ticks) : 0.0;
}

double tracking_rms_orientation_deg(const tracking_sums_t *sums) {
    return sums->ticks > 0 ? sqrt(sums->square_orientation_deg2 / (double)sums->ticks) : 0.0;
}
