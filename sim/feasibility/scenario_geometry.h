/* What no single key shows: whether the scene can be as the file describes it. Each check gives, on failure, false and
 * one line in `error`. A scenario that the seed has varied must be checked anew: values in errors are then the varied
 * ones. */
#ifndef COMANIP_SIM_SCENARIO_GEOMETRY_H
#define COMANIP_SIM_SCENARIO_GEOMETRY_H

#include "../scenario/scenario.h"

/* Motion, overlap, and: people start near the torso, what the robot holds is in its gripper. Makes a scene of its own:
 * call it before the run's is made. */
bool scenario_check_geometry(const scenario_t *self, char error[], size_t error_size);

/* The water stays in the robot's cup while it settles. No seed changes that, and it takes a while: check it once. */
bool scenario_check_water(const scenario_t *self, char error[], size_t error_size);

/* Nobody moves faster, or further, than a person can, in neither program. Ways that end where a thing then is are not
 * known beforehand (scenario_motion.c). */
bool scenario_check_motion(const scenario_t *self, char error[], size_t error_size);

/* At the start no object, cup, person or part of the robot is inside another, but for what the robot is about to grip
 * (scenario_overlap.c). */
bool scenario_check_overlap(const scenario_t *self, char error[], size_t error_size);

#endif
