/* The operator's steps in a run: the scenario's script, modified by options on the command line. */
#ifndef COMANIP_SIM_OPERATOR_SCRIPT_H
#define COMANIP_SIM_OPERATOR_SCRIPT_H

#include <stdbool.h>
#include <stddef.h>

#include "../../firmware/parameters/parameters.h"
#include "../scenario/scenario.h"
#include "operator_node.h"

#define OPERATOR_SCRIPT_CLUTCH_MIN_S 1.0 /* earliest time that --clutch accepts */
#define OPERATOR_SCRIPT_MAX_STEPS (PARAMETER_COUNT + SCENARIO_MAX_STEPS + 3)

/* Changes that the command line makes to the scenario's script. */
typedef struct {
    bool parameter_written[PARAMETER_COUNT]; /* true: parameter_value replaces the scenario's value */
    float parameter_value[PARAMETER_COUNT];
    bool defines_task; /* `task` replaces the scenario's first task */
    task_define_t task;
    double clutch_s; /* time of the clutch command, which waits until the arm cooperates; 0: no clutch */
} operator_overrides_t;

/* Fills `steps` (OPERATOR_SCRIPT_MAX_STEPS) and returns their number: the parameter writes, the wait for mode
 * ready, and the scenario's steps. The latch and clutch commands wait until the arm cooperates. The final stop command
 * is not included, because operator_node sends it itself. */
size_t operator_script(const scenario_t *scenario, const operator_overrides_t *overrides, operator_step_t steps[]);

#endif
