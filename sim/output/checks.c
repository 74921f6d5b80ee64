#include "checks.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "../monitors/measure.h"
#include "../monitors/rest_noise.h"

#define COOPERATION_MIN_S 0.1
#define REST_RADPS 0.02 /* limit without noise: ten times the speed that one encoder pulse commands at default gains */
#define REST_NOISES 5.0 /* limit with noise, as a multiple of the noise's RMS: random peaks stay below it */
/* Limit for recorded motion: a recorded hand rotates freely, and rotations that the arm's four joints cannot follow
 * cause position errors. */
#define RECORDING_RMS_LIMIT_MM 3.0

static check_t *add(checks_t *self, const char *name, double value, double limit, bool is_lower_bound,
                    const char *unit) {
    check_t *check = &self->check[self->count++];
    *check = (check_t){.name = name,
                       .measured = true,
                       .value = value,
                       .limit = limit,
                       .is_lower_bound = is_lower_bound,
                       .unit = unit,
                       .orientation_rest_deg = (double)NAN,
                       .pass = is_lower_bound ? value >= limit : value <= limit};
    return check;
}

static check_t *add_not_measured(checks_t *self, const char *name, double limit, bool is_lower_bound,
                                 const char *unit) {
    check_t *check = add(self, name, 0.0, limit, is_lower_bound, unit);
    check->measured = false;
    check->pass = false;
    return check;
}

static double fault_modes(const observer_t *observer) {
    double count = 0.0;
    for (size_t i = 0; i < observer->mode_count; i++) {
        count += observer->modes[i].mode == MODE_FAULT;
    }
    return count;
}

/* Returns the number of frames that were rejected, summed over all receivers. The firmware reports its own count in
 * FirmwareStatus; the counts of the other receivers are read directly. */
static double rejected_frames(const world_t *world) {
    return (double)world->observer.firmware_rejected + (double)world->observer.receiver.protocol.rejected +
           (double)drive_node_rejected(world->drives) + (double)gripper_node_rejected(world->gripper);
}

static void add_common(checks_t *self, const world_t *world) {
    const double dropped = (double)bus_statistics(world->bus).dropped + (double)world->firmware_overflows;
    add(self, "limit_violations", (double)world->observer.limits.violations, 0.0, false, "");
    add(self, "frames_dropped", dropped, 0.0, false, "");
    add(self, "frames_rejected", rejected_frames(world), 0.0, false, "");
    add(self, "fault_modes", fault_modes(&world->observer), 0.0, false, "");
    add(self, "commands_outstanding", operator_node_finished(world->operator) ? 0.0 : 1.0, 0.0, false, "");
    add(self, "cooperation_time", (double)world->tracking.cooperating_ticks * WORLD_TICK_NS * 1e-9, COOPERATION_MIN_S,
        true, "s");
}

bool checks_tracking_measured(const world_t *world) {
    return world->tracking.all.ticks > 0;
}

static bool is_trace_off(const world_t *world) {
    return world->observer.parameter[PARAMETER_TRACE] <= 0.0f && !checks_tracking_measured(world);
}

/* Returns true if --duration ended the run before all scripts were done. */
static bool is_cut_short(const world_t *world) {
    bool is_done = operator_node_script_done(world->operator);
    for (size_t i = 0; i < world->scenario->person_count; i++) {
        is_done = is_done && person_program_is_done(world->program[i]);
    }
    return world->is_shortened && !is_done;
}

/* ---- rest */

static double rest_limit_radps(const world_t *world) {
    const double motion_scale = (double)world->observer.parameter[PARAMETER_MOTION_SCALE];
    const bool predicts = world->observer.parameter[PARAMETER_PREDICTION] > 0.0f;
    return fmax(REST_RADPS,
                REST_NOISES * rest_noise_radps(world->scenario, &world->options->tracker, motion_scale, predicts));
}

__attribute__((format(printf, 2, 3))) static void set_rest_not_measured(checks_t *self, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(self->rest_not_measured, sizeof self->rest_not_measured, format, arguments);
    va_end(arguments);
}

/* Adds the check that the arm comes to rest. If rest cannot be measured, stores the reason instead. The check fails if
 * the hand moved although the person held it still, because an arm that oscillates and drags the hand along must not
 * escape the check. */
static void add_rest(checks_t *self, const world_t *world) {
    const rest_monitor_t *rest = &world->rest;
    const double limit_radps = rest_limit_radps(world);
    const double speed_max_radps =
        (double)world->observer.parameter[PARAMETER_SPEED_FRACTION] * ROBOT_VELOCITY_MAX_RADPS;
    if (limit_radps > REST_RADPS && limit_radps >= speed_max_radps) {
        set_rest_not_measured(
            self, "noise and tremor mask the motion: they may move a joint at %.3g rad/s, and its limit is %.3g rad/s",
            limit_radps, speed_max_radps);
    } else if (rest->disturbed) {
        add_not_measured(self, "comes_to_rest", limit_radps, false, "rad/s");
        set_rest_not_measured(self, "the hand kept moving although the person held it still");
    } else if (rest->measured) {
        add(self, "comes_to_rest", rest->speed_radps_max, limit_radps, false, "rad/s");
    } else if (is_cut_short(world)) {
        set_rest_not_measured(self, "the phase of rest lies beyond the end of the run");
    } else {
        set_rest_not_measured(self,
                              "hand and task were still for at most %.2f s, and the check needs %g s: end the program "
                              "of %s with {do: rest, duration_s: 3}",
                              rest->longest_s, REST_PHASE_S, world->scenario->person[world->scenario->tracked].name);
    }
}

/* ---- tracking of the target */

/* Checks only the position error, and only if there was enough followable motion. The share of followable motion is not
 * checked, because no expected share is known for a recorded hand or for a task given with --define. */
static void add_tracking_of_any_motion(checks_t *self, const world_t *world, bool is_enough) {
    if (is_enough) {
        add(self, "followable_rms_position", tracking_rms_position_mm(&world->tracking.followable),
            RECORDING_RMS_LIMIT_MM, false, "mm");
    } else {
        self->tracking_not_judged = checks_tracking_measured(world);
    }
}

/* Adds a check of the tracking, or counts the check as left out. A limit of 0 means that the scenario does not use the
 * check. */
static void add_tracking_check(checks_t *self, const world_t *world, const char *name, double value, double limit,
                               bool is_lower_bound, const char *unit, bool is_judgeable) {
    if (!(limit > 0.0)) {
        return;
    }
    if (is_trace_off(world)) {
        self->left_out_by_trace++;
    } else if (is_judgeable) {
        add(self, name, value, limit, is_lower_bound, unit);
    } else if (is_cut_short(world)) {
        self->left_out_by_end++;
    } else {
        add_not_measured(self, name, limit, is_lower_bound, unit);
    }
}

/* Checks the position error and requires a minimum share of followable motion, so that a controller that keeps the arm
 * at its limits cannot pass unchecked. */
static void add_tracking_of_script(checks_t *self, const world_t *world, bool is_enough) {
    const scenario_t *scenario = world->scenario;
    const tracking_t *tracking = &world->tracking;
    const double share = 100.0 * (double)tracking->followable.ticks / (double)tracking->settled_ticks;
    add_tracking_check(self, world, "followable_share", share, scenario->followable_min_percent, true, "%",
                       tracking->settled_ticks > 0 && !is_cut_short(world));
    add_tracking_check(self, world, "followable_rms_position", tracking_rms_position_mm(&tracking->followable),
                       scenario->tracking_rms_limit_mm, false, "mm", is_enough);
    add_tracking_check(self, world, "followable_max_position", tracking->followable.max_position_mm,
                       scenario->tracking_max_limit_mm, false, "mm", is_enough);
}

static void add_tracking(checks_t *self, const world_t *world) {
    const double followable_s = (double)world->tracking.followable.ticks * WORLD_TICK_NS * 1e-9;
    const bool is_enough = followable_s >= CHECKS_FOLLOWABLE_MIN_S;
    const bool has_limit = world->scenario->tracking_rms_limit_mm > 0.0, is_scripted = world_is_scripted(world);
    if (is_scripted) {
        add_tracking_of_script(self, world, is_enough);
    }
    if (has_limit ? !is_scripted : world->tracking.out_of_reach_ticks > 0) {
        add_tracking_of_any_motion(self, world, is_enough);
    }
}

/* ---- checks of the scenario */

/* Returns true if the run ended before the window did. A window without `until` lasts until the scenario's scripts
 * end. */
static bool is_beyond_the_end(const world_t *world, const scenario_check_t *check, const check_window_t *window) {
    return is_cut_short(world) && !(check->has_until && check_window_is_whole(window, check));
}

static bool has_clutch(const world_t *world, const check_window_t *window) {
    const double clutch_s = world->options->operator.clutch_s;
    return clutch_s > 0.0 && window->ticks > 0 && clutch_s >= window->first_s && clutch_s <= window->last_s;
}

static void judge(checks_t *self, const world_t *world, const scenario_check_t *check,
                  const measurement_t *measurement) {
    const char *unit = measure_unit(check->measure);
    if (measurement_is_valid(measurement, check)) {
        check_t *added =
            add(self, check->name, measurement_value(measurement, check), check->limit, check->is_lower_bound, unit);
        added->orientation_rest_deg = measurement_orientation_rest_deg(measurement, check);
        return;
    }
    check_t *added = add_not_measured(self, check->name, check->limit, check->is_lower_bound, unit);
    const int event = check_window_missing_event(&measurement->window, check, &world->events);
    added->missing_event = event == EVENT_NONE ? NULL : world->events.event[event].name;
}

static void add_scenario(checks_t *self, const world_t *world) {
    for (size_t i = 0; i < world->scenario->check_count; i++) {
        const scenario_check_t *check = &world->scenario->check[i];
        const measurement_t *measurement = &world->scenario_monitor.measurement[i];
        if (world->options->operator.defines_task) {
            self->left_out_by_define++;
        } else if (world->has_recording && measure_is_of_built_in_motion(check->measure)) {
            self->left_out_by_recording++;
        } else if (is_beyond_the_end(world, check, &measurement->window)) {
            self->left_out_by_end++;
        } else if (measure_compares_with_begin(check->measure) && has_clutch(world, &measurement->window)) {
            self->left_out_by_clutch++;
        } else if (measure_needs_target(check->measure) && is_trace_off(world)) {
            self->left_out_by_trace++;
        } else {
            judge(self, world, check, measurement);
        }
    }
}

void checks_evaluate(checks_t *self, const world_t *world) {
    memset(self, 0, sizeof *self);
    add_common(self, world);
    add_rest(self, world);
    add_tracking(self, world);
    add_scenario(self, world);
    self->pass = world->failure[0] == '\0';
    for (size_t i = 0; i < self->count; i++) {
        self->pass = self->pass && self->check[i].pass;
    }
}
