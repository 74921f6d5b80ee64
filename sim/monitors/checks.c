#include "checks.h"

#include <stdio.h>
#include <string.h>

#define COOPERATION_MIN_S 0.1
#define FOLLOWABLE_MIN_S 1.0       /* less is no basis for a judgement */
#define RECORDING_RMS_LIMIT_MM 3.0 /* wrists turn as they like, and what the arm cannot turn pulls at its position */

static void add(checks_t *self, const char *name, double value, double limit, bool is_lower_bound, const char *unit) {
    const bool pass = is_lower_bound ? value >= limit : value <= limit;
    self->check[self->count++] = (check_t){name, value, limit, is_lower_bound, unit, pass};
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

static void add_tracking(checks_t *self, const world_t *world) {
    const tracking_sums_t *sums = &world->tracking.followable;
    const scenario_t *scenario = world->options->scenario;
    const double followable_s = (double)sums->ticks * WORLD_TICK_NS * 1e-9;
    if (followable_s < FOLLOWABLE_MIN_S) {
        return;
    }
    if (world->options->tracker_path == NULL) {
        add(self, "followable_rms_position", tracking_rms_position_mm(sums), scenario->tracking_rms_limit_mm, false,
            "mm");
        add(self, "followable_max_position", sums->max_position_mm, scenario->tracking_max_limit_mm, false, "mm");
    } else {
        add(self, "followable_rms_position", tracking_rms_position_mm(sums), RECORDING_RMS_LIMIT_MM, false, "mm");
    }
}

static void add_scenario(checks_t *self, const world_t *world) {
    const scenario_monitor_t *monitor = &world->scenario_monitor;
    for (size_t i = 0; i < monitor->count; i++) {
        if (monitor->measured[i]) {
            const scenario_check_t *check = &monitor->checks[i];
            add(self, check->name, monitor->value[i], check->limit, scenario_check_is_lower_bound(check),
                scenario_check_unit(check));
        }
    }
}

static void explain(checks_t *self, const world_t *world) {
    const check_t *first = NULL;
    size_t failed = 0;
    for (size_t i = 0; i < self->count; i++) {
        if (!self->check[i].pass) {
            failed++;
            first = first == NULL ? &self->check[i] : first;
        }
    }
    self->pass = failed == 0 && world->failure[0] == '\0';
    if (world->failure[0] != '\0') {
        (void)snprintf(self->reason, sizeof self->reason, "%s", world->failure);
    } else if (first != NULL) {
        const bool by_limits = world->observer.limits.first[0] != '\0';
        (void)snprintf(self->reason, sizeof self->reason, "%zu of %zu checks failed; first: %s is %.6g%s%s, %s %.6g%s%s",
                       failed, self->count, first->name, first->value, first->unit[0] != '\0' ? " " : "", first->unit,
                       first->is_lower_bound ? "expected at least" : "expected at most", first->limit,
                       by_limits ? "; " : "", world->observer.limits.first);
    } else {
        (void)snprintf(self->reason, sizeof self->reason, "all %zu checks passed%s", self->count,
                       checks_tracking_measured(world) ? "" : "; tracking was not measured: the trace is switched off");
    }
}

void checks_evaluate(checks_t *self, const world_t *world) {
    memset(self, 0, sizeof *self);
    add_common(self, world);
    add_tracking(self, world);
    add_scenario(self, world);
    explain(self, world);
}
