#include "scenario_monitor.h"

#include <math.h>
#include <string.h>

#include "../common/rigid_pose.h"
#include "tracking.h"

#define TICK_S 0.001

void scenario_monitor_init(scenario_monitor_t *self, const scenario_check_t checks[], size_t count) {
    memset(self, 0, sizeof *self);
    self->checks = checks;
    self->count = count;
}

bool scenario_check_needs_target(const scenario_check_t *check) {
    return check->kind == CHECK_SETTLED_POSITION;
}

bool scenario_check_needs_start(const scenario_check_t *check) {
    return check->kind == CHECK_DISPLACEMENT || check->kind == CHECK_TURN;
}

static double check_start_s(const scenario_check_t *check) {
    return check->from_s > 0.0 ? check->from_s : check->until_s; /* of a single instant */
}

bool scenario_monitor_has_measured(const scenario_monitor_t *self, size_t check) {
    const double window_s = self->checks[check].until_s - check_start_s(&self->checks[check]);
    return self->ticks[check] > 0 && (double)self->ticks[check] * TICK_S >= 0.5 * window_s;
}

bool scenario_check_is_lower_bound(const scenario_check_t *check) {
    return check->kind == CHECK_TILT;
}

const char *scenario_check_unit(const scenario_check_t *check) {
    return check->kind == CHECK_TILT || check->kind == CHECK_TURN ? "deg" : "mm";
}

/* How far the hand's axis that pointed up at the start has tilted. */
static double tilt_deg(const rigid_pose_t *start, const rigid_pose_t *now) {
    const double up[3] = {0.0, 0.0, 1.0};
    const double from_torso[4] = {start->rotation[0], -start->rotation[1], -start->rotation[2], -start->rotation[3]};
    double axis[3], tilted[3];
    rotation_apply(from_torso, up, axis);
    rotation_apply(now->rotation, axis, tilted);
    return atan2(hypot(tilted[0], tilted[1]), tilted[2]) / ROBOT_RAD_PER_DEG;
}

static double displacement_error_mm(const rigid_pose_t *start, const rigid_pose_t *now, const double expected_m[3],
                                    double motion_scale) {
    double square = 0.0;
    for (int k = 0; k < 3; k++) {
        const double error_m = now->position_m[k] - start->position_m[k] - motion_scale * expected_m[k];
        square += error_m * error_m;
    }
    return 1e3 * sqrt(square);
}

static double measure(const scenario_check_t *check, const rigid_pose_t *start, const tick_record_t *tick,
                      double motion_scale) {
    switch (check->kind) {
    case CHECK_SETTLED_POSITION:
        return tracking_distance_mm(tick);
    case CHECK_DISPLACEMENT:
        return displacement_error_mm(start, &tick->hand, check->expected_m, motion_scale);
    case CHECK_TILT:
        return tilt_deg(start, &tick->hand);
    case CHECK_TURN:
        return fabs(rotation_angle_between(start->rotation, tick->hand.rotation) / ROBOT_RAD_PER_DEG -
                    check->expected_deg);
    }
    return 0.0;
}

void scenario_monitor_sample(scenario_monitor_t *self, const tick_record_t *tick, double motion_scale) {
    if (!self->has_start) {
        if (tick->mode != MODE_COOPERATING) {
            return;
        }
        self->has_start = true;
        self->start = tick->hand;
    }
    const double t_s = (double)tick->time_ns * 1e-9;
    for (size_t i = 0; i < self->count; i++) {
        const scenario_check_t *check = &self->checks[i];
        const double from_s = check_start_s(check);
        if (check->since_s > 0.0 && fabs(t_s - check->since_s) < 0.0005) {
            self->since[i] = tick->hand;
            self->has_since[i] = true;
        }
        /* A tick's time is a multiple of 1 ms: half a tick of slack makes the comparison exact. */
        if (t_s < from_s - 0.0005 || t_s > check->until_s + 0.0005 ||
            (scenario_check_needs_target(check) && !tick->has_target) || (check->since_s > 0.0 && !self->has_since[i])) {
            continue;
        }
        const double value = measure(check, check->since_s > 0.0 ? &self->since[i] : &self->start, tick, motion_scale);
        const bool worse = scenario_check_is_lower_bound(check) ? value < self->value[i] : value > self->value[i];
        if (self->ticks[i] == 0 || worse) {
            self->value[i] = value;
        }
        self->ticks[i]++;
    }
}
