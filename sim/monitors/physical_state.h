/* A snapshot of the physical scene at one instant, with all data that the monitors and the trace need. */
#ifndef COMANIP_SIM_PHYSICAL_STATE_H
#define COMANIP_SIM_PHYSICAL_STATE_H

#include <stdbool.h>
#include <stddef.h>

#include "../proximity/proximity.h"
#include "../scenario/scenario.h"
#include "../scene/scene.h"
#include "../scene/water.h"

#define PHYSICAL_STATE_NONE (-1)

typedef struct {
    /* Constant during a run. */
    size_t person_count, tracked, object_count;
    int second;        /* the person who is not tracked, or PHYSICAL_STATE_NONE */
    int traced_object; /* the first object that is not a stand, or PHYSICAL_STATE_NONE */
    int crank;         /* the first crank, or PHYSICAL_STATE_NONE */
    bool has_water, has_robot_cup;

    /* Changes during a run. */
    rigid_pose_t hand[SCENARIO_MAX_PEOPLE];
    double hand_force_N[SCENARIO_MAX_PEOPLE][3]; /* exerted by the held object, over the last step */
    rigid_pose_t object[SCENARIO_MAX_OBJECTS];
    double crank_turns[SCENARIO_MAX_OBJECTS];                  /* 0 for other objects */
    bool holds[SCENARIO_MAX_PEOPLE + 1][SCENARIO_MAX_OBJECTS]; /* [person or SCENE_HOLDER_ROBOT][object] */
    double gripper_opening, gripper_force_N;
    rigid_pose_t robot_cup; /* valid if has_robot_cup */
    water_count_t water;
    measured_clearance_t clearance;
} physical_state_t;

void physical_state_read(physical_state_t *self, const scenario_t *scenario, const scene_t *scene,
                         const measured_clearance_t *clearance);

/* Returns the magnitude [N] of the force at this person's hand. */
double physical_state_force_N(const physical_state_t *self, size_t person);

/* Returns true if the holder, a person or SCENE_HOLDER_ROBOT, holds any object. */
bool physical_state_holds_any(const physical_state_t *self, size_t holder);

#endif
