/* The pass/fail list of a run: checks common to all scenarios, how the target was followed, and the scenario's own. */
#ifndef COMANIP_SIM_CHECKS_H
#define COMANIP_SIM_CHECKS_H

#include "../world/world.h"

#define CHECKS_MAX (16 + SCENARIO_MAX_CHECKS)
#define CHECKS_FOLLOWABLE_MIN_S 1.0 /* less is no basis for a judgement */

typedef struct {
    const char *name;
    bool measured; /* false: there is no value, though the run should have given one: a failure */
    double value;
    double limit;
    bool is_lower_bound; /* value must be at least the limit; else at most */
    const char *unit;
    bool pass;
    double orientation_rest_deg; /* RMS over the same ticks, not judged; NaN: none */
    const char *missing_event;   /* why it was not measured: this never happened; NULL */
} check_t;

typedef struct {
    check_t check[CHECKS_MAX];
    size_t count;
    size_t left_out_by_end;       /* of the scenario's: they lie beyond the end of a shortened run */
    size_t left_out_by_clutch;    /* the operator took a new reference since what they count from */
    size_t left_out_by_trace;     /* they need the target, and the trace is switched off */
    size_t left_out_by_recording; /* they ask for what the built-in motion does */
    size_t left_out_by_define;    /* they ask for what the scenario's own task does */
    char rest_not_measured[200];  /* why there is nothing to judge comes_to_rest by; "": there is */
    bool tracking_not_judged;     /* of a recording: there was too little that the arm could follow */
    bool pass;                    /* all of them, and the run came to its end */
    char reason[1200];            /* of the result, one line: reason.h */
} checks_t;

/* All but the reason. */
void checks_evaluate(checks_t *self, const world_t *world);

/* Targets are known from TickTrace frames only; without any there is no tracking. */
bool checks_tracking_measured(const world_t *world);

#endif
