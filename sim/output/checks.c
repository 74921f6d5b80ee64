#include "checks.h"

#include <string.h>

#include "reason.h"

#define COOPERATION_MIN_S 0.1
#define RECORDING_RMS_LIMIT_MM 3.0 /* wrists turn as they like, and what the arm cannot turn pulls at its position */
#define HALF_A_TICK_S (0.5e-9 * WORLD_TICK_NS) /* of slack makes comparisons of tick times exact */

static void add(checks_t *self, const char *name, double value, double limit, bool is_lower_bound, const char *unit) {
    const bool pass = is_lower_bound ? value >= limit : value <= limit;
    self->check[self->count++] = (check_t){name, true, value, limit, is_lower_bound, unit, pass};
}

static void add_not_measured(checks_t *self, const char *name, double limit, bool is_lower_bound, const char *unit) {
    self->check[self->count++] = (check_t){name, false, 0.0, limit, is_lower_bound, unit, false};
}

static double fault_modes(const observer_t *observer) {
    double count = 0.0;
    for (size_t i = 0; i < observer->mode_count; i++) {
        count += observer->modes[i].mode == MODE_FAULT;
    }
    return count;
}

/* Frames that some receiver refused: the firmware says so in its status, the others are asked. */
static double rejected_frames(const world_t *world) {
    return (double)world->observer.firmware_rejected + (double)world->observer.receiver.rejected +
           (double)drive_node_rejected(world->drives);
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

/* When the operator stops the arm; in a run that ended early, when it would have had to. */
static double stop_s(const world_t *world) {
    return (double)world->now_ns * 1e-9 - SCENARIO_STOP_BEFORE_END_S + HALF_A_TICK_S;
}

static void add_rms(checks_t *self, const world_t *world, double limit_mm) {
    add(self, "followable_rms_position", tracking_rms_position_mm(&world->tracking.followable), limit_mm, false, "mm");
}

/* What a recorded hand or a task of the operator's asks for is not known beforehand. */
static void add_tracking_of_any_motion(checks_t *self, const world_t *world, bool is_enough) {
    if (is_enough) {
        add_rms(self, world, RECORDING_RMS_LIMIT_MM);
    } else {
        self->tracking_not_judged = checks_tracking_measured(world);
    }
}

/* A law that keeps the arm at its limits is not to escape its judge: hence the least share. */
static void add_tracking_of_script(checks_t *self, const world_t *world, bool is_enough) {
    const scenario_t *scenario = world->options->scenario;
    const tracking_t *tracking = &world->tracking;
    if (is_trace_off(world)) {
        self->left_out_by_trace += 3;
        return;
    }
    const bool is_shortened = stop_s(world) < scenario->duration_s - SCENARIO_STOP_BEFORE_END_S;
    if (is_shortened) {
        self->left_out_by_end++;
    } else if (tracking->settled_ticks == 0) {
        add_not_measured(self, "followable_share", scenario->followable_min_percent, true, "%");
    } else {
        add(self, "followable_share",
            100.0 * (double)tracking->followable.ticks / (double)tracking->settled_ticks,
            scenario->followable_min_percent, true, "%");
    }
    if (is_enough) {
        add_rms(self, world, scenario->tracking_rms_limit_mm);
        add(self, "followable_max_position", tracking->followable.max_position_mm, scenario->tracking_max_limit_mm,
            false, "mm");
    } else if (is_shortened) {
        self->left_out_by_end += 2;
    } else {
        add_not_measured(self, "followable_rms_position", scenario->tracking_rms_limit_mm, false, "mm");
        add_not_measured(self, "followable_max_position", scenario->tracking_max_limit_mm, false, "mm");
    }
}

static void add_tracking(checks_t *self, const world_t *world) {
    const double followable_s = (double)world->tracking.followable.ticks * WORLD_TICK_NS * 1e-9;
    const bool is_enough = followable_s >= CHECKS_FOLLOWABLE_MIN_S;
    if (world_is_scripted(world)) {
        add_tracking_of_script(self, world, is_enough);
    } else {
        add_tracking_of_any_motion(self, world, is_enough);
    }
}

static void add_scenario(checks_t *self, const world_t *world) {
    const scenario_monitor_t *monitor = &world->scenario_monitor;
    const double clutch_s = world->options->operator.clutch_s;
    for (size_t i = 0; i < monitor->count; i++) {
        const scenario_check_t *check = &monitor->checks[i];
        const char *unit = scenario_check_unit(check);
        const bool is_lower_bound = scenario_check_is_lower_bound(check);
        if (check->until_s > stop_s(world)) {
            self->left_out_by_end++;
        } else if (scenario_check_needs_start(check) && clutch_s > 0.0 && clutch_s <= check->until_s) {
            self->left_out_by_clutch++;
        } else if (scenario_check_needs_target(check) && is_trace_off(world)) {
            self->left_out_by_trace++;
        } else if (scenario_monitor_has_measured(monitor, i)) {
            add(self, check->name, monitor->value[i], check->limit, is_lower_bound, unit);
        } else {
            add_not_measured(self, check->name, check->limit, is_lower_bound, unit);
        }
    }
}

void checks_evaluate(checks_t *self, const world_t *world) {
    memset(self, 0, sizeof *self);
    add_common(self, world);
    add_tracking(self, world);
    add_scenario(self, world);
    self->pass = world->failure[0] == '\0';
    for (size_t i = 0; i < self->count; i++) {
        self->pass = self->pass && self->check[i].pass;
    }
    reason_write(self, world);
}
