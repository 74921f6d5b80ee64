/* Measures, tick by tick, what a scenario's own checks ask for. */
#ifndef COMANIP_SIM_SCENARIO_MONITOR_H
#define COMANIP_SIM_SCENARIO_MONITOR_H

#include "../scenario.h"
#include "observer.h"

#define SCENARIO_MAX_CHECKS 16

typedef struct {
    const scenario_check_t *checks;
    size_t count;
    bool has_start;
    rigid_pose_t start; /* ODE's hand at the first tick in cooperation */
    rigid_pose_t since[SCENARIO_MAX_CHECKS]; /* and at the time since which a displacement counts */
    bool has_since[SCENARIO_MAX_CHECKS];
    double value[SCENARIO_MAX_CHECKS];
    uint64_t ticks[SCENARIO_MAX_CHECKS]; /* in which it was measured */
} scenario_monitor_t;

/* count: at most SCENARIO_MAX_CHECKS. */
void scenario_monitor_init(scenario_monitor_t *self, const scenario_check_t checks[], size_t count);

void scenario_monitor_sample(scenario_monitor_t *self, const tick_record_t *tick, double motion_scale);

/* In at least half of the ticks that the check covers. */
bool scenario_monitor_has_measured(const scenario_monitor_t *self, size_t check);

/* The target is known from TickTrace alone. */
bool scenario_check_needs_target(const scenario_check_t *check);

/* It compares with the hand at the start command. */
bool scenario_check_needs_start(const scenario_check_t *check);

/* CHECK_TILT asks for at least its limit, all others for at most. */
bool scenario_check_is_lower_bound(const scenario_check_t *check);
const char *scenario_check_unit(const scenario_check_t *check);

#endif
