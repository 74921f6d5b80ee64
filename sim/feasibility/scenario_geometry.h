/* Checks whether the scene is physically possible, which no single key of the scenario file can show. Each check
 * returns false on failure, with one line in `error`. After the seed has varied a scenario, the scenario must be
 * checked again; error messages then show the varied values. */
#ifndef COMANIP_SIM_SCENARIO_GEOMETRY_H
#define COMANIP_SIM_SCENARIO_GEOMETRY_H

#include "../scenario/scenario.h"

/* Checks that people start near the torso and that the robot holds at most one object, in its gripper; also runs
 * scenario_check_motion() and scenario_check_overlap(). Creates a temporary scene, so this function must be called
 * before the scene of the run is created. */
bool scenario_check_geometry(const scenario_t *self, char error[], size_t error_size);

/* Checks that the water stays in the robot's cup while the water settles. The check is slow and independent of the
 * seed, so one call is enough. */
bool scenario_check_water(const scenario_t *self, char error[], size_t error_size);

/* Checks that no program moves a hand faster or farther than a person can. A move to an object is not checked, because
 * the length of the move is not known in advance (scenario_motion.c). */
bool scenario_check_motion(const scenario_t *self, char error[], size_t error_size);

/* Checks that at the start no object, cup, person or part of the robot is inside another. Objects may overlap hands,
 * forearms and the gripper, so that they can be gripped (scenario_overlap.c). */
bool scenario_check_overlap(const scenario_t *self, char error[], size_t error_size);

#endif
