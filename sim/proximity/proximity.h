/* Least clearances, each tick: between people and robot outside intended contact, and between the arm and the rest
 * of the robot. A monitor as a light curtain is one: it knows where everything is, and the operator hears of it over
 * the bus. */
#ifndef COMANIP_SIM_PROXIMITY_H
#define COMANIP_SIM_PROXIMITY_H

#include "../scene/scene.h"
#include "convex_distance.h"

#define PROXIMITY_PAIR_BYTES 64
#define PROXIMITY_CEILING_M 1.0 /* a clearance beyond it counts as this */

typedef struct {
    double person_m; /* PROXIMITY_CEILING_M: there is nothing near */
    double self_m;
    int person_pair, self_pair; /* numbers for proximity_pair_name(); -1: none */
} measured_clearance_t;

/* What a pair's number stands for. */
typedef struct {
    int person;         /* in the order of the scenario; -1: the robot with itself */
    person_part_t part; /* of the person */
    robot_part_t robot; /* near the person; with itself: of the arm and what it carries */
    robot_part_t body;  /* with itself: what that is near to */
} proximity_pair_t;

proximity_pair_t proximity_pair(int pair);

typedef struct proximity proximity_t;

/* Scenario and scene must outlive it. NULL: no memory. */
proximity_t *proximity_create(const scenario_t *scenario, const scene_t *scene);
void proximity_destroy(proximity_t *self);

/* Of this instant. Error at most CONVEX_DISTANCE_ERROR_M each. */
measured_clearance_t proximity_measure(proximity_t *self);

/* As "person.forearm - robot.forearm"; "" for -1. */
const char *proximity_pair_name(const proximity_t *self, int pair);

#endif
