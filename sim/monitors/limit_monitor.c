#include "limit_monitor.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Half the resolution of the values in JointCmd, plus float32 rounding. */
#define POSITION_TOLERANCE_RAD 1e-6
#define VELOCITY_TOLERANCE_RADPS 0.51e-3
#define VELOCITY_STEP_TOLERANCE_RADPS 1e-5 /* commands are whole mrad/s, so only float32 rounding remains */
#define TICK_NS 1000000

void limit_monitor_init(limit_monitor_t *self) {
    memset(self, 0, sizeof *self);
}

static void count_violation(limit_monitor_t *self, int64_t end_ns, int joint, const char *what, double value,
                            double limit) {
    if (self->violations++ == 0) {
        (void)snprintf(self->first, sizeof self->first, "joint %d at %.6f s: %s %.6g beyond %.6g", joint,
                       (double)end_ns * 1e-9, what, value, limit);
    }
}

void limit_monitor_undecodable(limit_monitor_t *self, int64_t end_ns) {
    if (self->violations++ == 0) {
        (void)snprintf(self->first, sizeof self->first, "JointCmd at %.6f s cannot be decoded", (double)end_ns * 1e-9);
    }
}

/* Returns the number of ticks since the last command. The time is rounded to whole ticks. The result is exact, because
 * frames jitter by less than half a tick. */
static double ticks_since_last(const limit_monitor_t *self, int64_t end_ns) {
    const double ticks = nearbyint((double)(end_ns - self->last_ns) / TICK_NS);
    return ticks < 1.0 ? 1.0 : ticks;
}

/* Returns the time from the middle of the last interval to the middle of this one. The mean accelerations of the two
 * intervals differ by at most the jerk limit times this time. */
static double centre_distance_s(const limit_monitor_t *self, double interval_s) {
    return 0.5 * (interval_s + self->last_interval_s);
}

/* Returns the lowest speed to which the joint can have braked since the last command. */
static double slowest_radps(const limit_monitor_t *self, int joint, double acceleration_max_radps2, double interval_s) {
    const double last_radps = self->last_velocity_radps[joint];
    const double growth_radps2 = copysign(1.0, last_radps) * self->last_acceleration_radps2[joint];
    const double least_radps2 = growth_radps2 - ROBOT_JERK_MAX_RADPS3 * centre_distance_s(self, interval_s);
    return fabs(last_radps) + fmax(least_radps2, -acceleration_max_radps2) * interval_s;
}

static void check_jerk(limit_monitor_t *self, int64_t end_ns, int joint, double acceleration_radps2,
                       double interval_s) {
    const double jerk_radps3 =
        fabs(acceleration_radps2 - self->last_acceleration_radps2[joint]) / centre_distance_s(self, interval_s);
    const double tolerance_radps3 = 2.0 * VELOCITY_STEP_TOLERANCE_RADPS / (interval_s * self->last_interval_s);
    if (!(jerk_radps3 <= ROBOT_JERK_MAX_RADPS3 + tolerance_radps3)) {
        count_violation(self, end_ns, joint, "jerk [rad/s^3]", jerk_radps3, ROBOT_JERK_MAX_RADPS3);
    }
}

static void check_joint(limit_monitor_t *self, const joint_cmd_t *command, int64_t end_ns, int joint,
                        double velocity_max_radps, double acceleration_max_radps2, double interval_s) {
    const double position_rad = (double)command->position_rad[joint];
    const double velocity_radps = (double)command->velocity_radps[joint];
    const double minimum_rad = robot_model_position_min_rad(joint), maximum_rad = robot_model_position_max_rad(joint);
    /* The comparisons are negated, so that NaN counts as a violation. */
    if (!(position_rad >= minimum_rad - POSITION_TOLERANCE_RAD)) {
        count_violation(self, end_ns, joint, "position [rad]", position_rad, minimum_rad);
    }
    if (!(position_rad <= maximum_rad + POSITION_TOLERANCE_RAD)) {
        count_violation(self, end_ns, joint, "position [rad]", position_rad, maximum_rad);
    }
    const double least_radps = slowest_radps(self, joint, acceleration_max_radps2, interval_s);
    const double allowed_radps = fmin(fmax(velocity_max_radps, least_radps), ROBOT_VELOCITY_MAX_RADPS);
    if (!(fabs(velocity_radps) <= allowed_radps + VELOCITY_TOLERANCE_RADPS)) {
        count_violation(self, end_ns, joint, "velocity [rad/s]", velocity_radps, allowed_radps);
    }
    if (command->mode[joint] != DRIVE_MODE_BRAKE && command->mode[joint] != DRIVE_MODE_VELOCITY) {
        count_violation(self, end_ns, joint, "mode", (double)command->mode[joint], (double)DRIVE_MODE_VELOCITY);
    }
    /* Brake mode counts as a velocity of 0, so braking a moving joint is checked against the acceleration limit as
     * well. */
    const double commanded_radps = command->mode[joint] == DRIVE_MODE_BRAKE ? 0.0 : velocity_radps;
    const double acceleration_radps2 = (commanded_radps - self->last_velocity_radps[joint]) / interval_s;
    const double step_radps = fabs(commanded_radps - self->last_velocity_radps[joint]);
    const double velocity_step_max_radps = acceleration_max_radps2 * interval_s;
    if (self->has_last && !(step_radps <= velocity_step_max_radps + VELOCITY_STEP_TOLERANCE_RADPS)) {
        count_violation(self, end_ns, joint, "velocity step [rad/s]", step_radps, velocity_step_max_radps);
    }
    if (self->last_interval_s > 0.0) {
        check_jerk(self, end_ns, joint, acceleration_radps2, interval_s);
    }
    self->last_velocity_radps[joint] = commanded_radps;
    self->last_acceleration_radps2[joint] = self->has_last ? acceleration_radps2 : 0.0;
}

void limit_monitor_command(limit_monitor_t *self, const joint_cmd_t *command, int64_t end_ns, double speed_fraction,
                           double acceleration_max_radps2) {
    const double interval_s = ticks_since_last(self, end_ns) * TICK_NS * 1e-9;
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        check_joint(self, command, end_ns, i, speed_fraction * ROBOT_VELOCITY_MAX_RADPS, acceleration_max_radps2,
                    interval_s);
    }
    for (int i = ROBOT_JOINTS; i < ARM_MAX_JOINTS; i++) { /* joints that this arm does not have */
        if (command->mode[i] != DRIVE_MODE_BRAKE || !(command->velocity_radps[i] == 0.0f)) {
            count_violation(self, end_ns, i, "velocity of a nonexistent joint", (double)command->velocity_radps[i],
                            0.0);
        }
    }
    self->last_interval_s = self->has_last ? interval_s : 0.0;
    self->has_last = true;
    self->last_ns = end_ns;
}
