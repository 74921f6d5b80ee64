/* Measures the smallest clearances in each tick: between the people and the robot (except for intended contact), and
 * between the arm and the rest of the robot. Like a light curtain, this sensor is not part of the robot. It sends its
 * results to the operator over the bus. */
#ifndef COMANIP_SIM_PROXIMITY_H
#define COMANIP_SIM_PROXIMITY_H

#include "../scene/scene.h"
#include "convex_distance.h"

#define PROXIMITY_PAIR_BYTES 64
#define PROXIMITY_CEILING_M 1.0 /* largest clearance that is measured */

typedef struct {
    double person_m; /* PROXIMITY_CEILING_M if nothing is near */
    double self_m;
    int person_pair, self_pair; /* indices for proximity_pair_name(); -1 if there is none */
} measured_clearance_t;

/* The two parts of a pair. */
typedef struct {
    int person;         /* index in the scenario; -1 for two parts of the robot */
    person_part_t part; /* the person's part */
    robot_part_t robot; /* the robot's part; if both parts are the robot's, the part of the arm or its load */
    robot_part_t body;  /* the other part if both are the robot's */
} proximity_pair_t;

proximity_pair_t proximity_pair(int pair);

typedef struct proximity proximity_t;

/* Scenario and scene must outlive self. Returns NULL if out of memory. */
proximity_t *proximity_create(const scenario_t *scenario, const scene_t *scene);
void proximity_destroy(proximity_t *self);

/* Measures the clearances at this instant. The error of each clearance is at most CONVEX_DISTANCE_ERROR_M. */
measured_clearance_t proximity_measure(proximity_t *self);

/* Returns the name of a pair, for example "person.forearm - robot.forearm"; "" for -1. */
const char *proximity_pair_name(const proximity_t *self, int pair);

#endif
