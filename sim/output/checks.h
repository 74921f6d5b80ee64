/* The pass/fail list of a run: checks common to all scenarios, tracking of the target, and the scenario's checks. */
#ifndef COMANIP_SIM_CHECKS_H
#define COMANIP_SIM_CHECKS_H

#include "../world/world.h"

#define CHECKS_MAX (16 + SCENARIO_MAX_CHECKS)
#define CHECKS_FOLLOWABLE_MIN_S 1.0 /* followable motion (tracking.h) without which the tracking is not checked */

typedef struct {
    const char *name;
    bool measured; /* false: the run should have produced a value but did not, so the check failed */
    double value;
    double limit;
    bool is_lower_bound; /* true: the value must be at least the limit; false: at most the limit */
    const char *unit;
    bool pass;
    double orientation_rest_deg; /* RMS orientation error in the ticks of `value`; not checked; NaN: not measured */
    const char *missing_event;   /* the event whose absence prevented the measurement; NULL: none */
} check_t;

typedef struct {
    check_t check[CHECKS_MAX];
    size_t count;
    size_t left_out_by_end;       /* checks left out because the shortened run ended before their window did */
    size_t left_out_by_clutch;    /* checks left out because a clutch within their window set a new reference */
    size_t left_out_by_trace;     /* checks left out because they need the target, but the trace is switched off */
    size_t left_out_by_recording; /* checks left out because they apply only to the built-in motion */
    size_t left_out_by_define;    /* checks left out because they apply only to the scenario's own task */
    char rest_not_measured[200];  /* why comes_to_rest was not measured; "" if it was */
    bool tracking_not_judged;     /* not checked, because the arm could follow the target for too short a time */
    bool pass;                    /* all checks passed, and the run was completed */
    char reason[1200];            /* reason for the result, in one line (reason.h) */
} checks_t;

/* Fills all members but `reason`. */
void checks_evaluate(checks_t *self, const world_t *world);

/* Returns false if no TickTrace with a target was received; no other frame carries the target. */
bool checks_tracking_measured(const world_t *world);

#endif
