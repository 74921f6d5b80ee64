/* The built-in scenarios as data: where the arm starts, what the person's hand does, what the operator does when, and
 * what must come out. docs/scenarios.md explains each number. */
#ifndef COMANIP_SIM_SCENARIO_H
#define COMANIP_SIM_SCENARIO_H

#include <stdbool.h>
#include <stddef.h>

#include "../firmware/parameters.h"
#include "../firmware/task.h"
#include "hand/hand_motion.h"
#include "nodes/operator_node.h"
#include "robot/robot_model.h"

typedef enum {
    /* Largest distance between ODE's hand and the target in [from_s, until_s]. */
    CHECK_SETTLED_POSITION,
    /* Distance between the way of ODE's hand since since_s, at until_s, and `expected_m` times motion_scale. */
    CHECK_DISPLACEMENT,
    /* Least angle in [from_s, until_s] between torso z and the axis of the hand that was along torso z at the start. */
    CHECK_TILT,
    /* Angle at until_s by which the hand has turned since the start command, less `expected_deg`. */
    CHECK_TURN,
} scenario_check_kind_t;

typedef struct {
    scenario_check_kind_t kind;
    const char *name;
    double from_s, until_s;
    double since_s;       /* CHECK_DISPLACEMENT; 0: since the start command */
    double expected_m[3]; /* CHECK_DISPLACEMENT, torso axes */
    double expected_deg;  /* CHECK_TURN */
    double limit;         /* mm or deg: at most so much; CHECK_TILT: at least so much */
} scenario_check_t;

typedef struct {
    const char *name;
    const char *summary;
    task_id_t task;
    double start_deg[ROBOT_JOINTS];
    double command_start_s; /* the operator's start */
    double motion_start_s;  /* first leg, or first sample of a recording */
    double latch_s;         /* 0: the operator does not latch */
    double duration_s;      /* with the built-in motion */
    rigid_pose_t hand_start; /* the person's hand, torso axes */
    const motion_leg_t *legs;
    size_t leg_count;
    const scenario_check_t *checks; /* with the built-in motion only */
    size_t check_count;
    double tracking_rms_limit_mm, tracking_max_limit_mm; /* ODE's hand against the target where it can be followed */
    double followable_min_percent; /* of the cooperation; no move of a script comes near the arm's limits for long */
} scenario_t;

extern const scenario_t scenario_table[];
extern const size_t scenario_count;

/* NULL if there is none of this name. */
const scenario_t *scenario_find(const char *name);

#define SCENARIO_STOP_BEFORE_END_S 0.5 /* the operator's stop */
#define SCENARIO_CLUTCH_MIN_S 1.0      /* no clutch before: the cooperation has begun */
#define SCENARIO_MAX_STEPS (PARAMETER_COUNT + 10)

/* What the operator shall do beside the scenario's script. */
typedef struct {
    bool parameter_written[PARAMETER_COUNT]; /* before all else */
    float parameter_value[PARAMETER_COUNT];
    bool defines_task; /* in place of the scenario's task */
    task_define_t task;
    double clutch_s; /* 0: no clutch */
} operator_wishes_t;

/* What the operator does in a run of this duration. Fills `steps` (SCENARIO_MAX_STEPS) and gives their number. */
size_t scenario_script(const scenario_t *self, double duration_s, const operator_wishes_t *wishes,
                       operator_step_t steps[]);

#endif
