/* What the operator does in a run, as steps of the operator node: the scenario's script, and what the command line
 * wants beside it. */
#ifndef COMANIP_SIM_OPERATOR_SCRIPT_H
#define COMANIP_SIM_OPERATOR_SCRIPT_H

#include <stdbool.h>
#include <stddef.h>

#include "../../firmware/parameters/parameters.h"
#include "../scenario/scenario.h"
#include "operator_node.h"

#define OPERATOR_SCRIPT_CLUTCH_MIN_S 1.0 /* no clutch before: the cooperation has begun */
#define OPERATOR_SCRIPT_MAX_STEPS (PARAMETER_COUNT + SCENARIO_MAX_STEPS + 3)

/* What the operator shall do beside the scenario's script. */
typedef struct {
    bool parameter_written[PARAMETER_COUNT]; /* before all else; in place of the scenario's value */
    float parameter_value[PARAMETER_COUNT];
    bool defines_task; /* in place of the scenario's first task */
    task_define_t task;
    double clutch_s; /* 0: no clutch. Else then, or as soon after as the arm cooperates */
} operator_wishes_t;

/* Parameters, then the wait for mode ready, then the scenario's steps. Latch and clutch wait for the cooperation. The
 * closing stop is the node's. Fills `steps` (OPERATOR_SCRIPT_MAX_STEPS) and gives their number. */
size_t operator_script(const scenario_t *scenario, const operator_wishes_t *wishes, operator_step_t steps[]);

#endif
