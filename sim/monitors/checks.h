/* The pass/fail list of a run: checks common to all scenarios, how the target was followed, and the scenario's own. */
#ifndef COMANIP_SIM_CHECKS_H
#define COMANIP_SIM_CHECKS_H

#include "world.h"

#define CHECKS_MAX (16 + SCENARIO_MAX_CHECKS)

typedef struct {
    const char *name;
    double value;
    double limit;
    bool is_lower_bound; /* value must be at least the limit; else at most */
    const char *unit;
    bool pass;
} check_t;

typedef struct {
    check_t check[CHECKS_MAX];
    size_t count;
    bool pass;         /* all of them, and the run came to its end */
    char reason[400];  /* of the result, one line */
} checks_t;

void checks_evaluate(checks_t *self, const world_t *world);

/* Targets are known from TickTrace frames only; without any there is no tracking. */
bool checks_tracking_measured(const world_t *world);

#endif
