/* Provides what a person sees of the scene, apart from the positions of points: the angle of a crank and the distance
 * to an object. Also names points in messages. */
#ifndef COMANIP_SIM_SIGHT_H
#define COMANIP_SIM_SIGHT_H

#include "../scene/scene.h"

/* Returns the angle through which the crank has turned since the start. */
double sight_crank_rad(const scene_t *scene, size_t object);

/* Returns the distance from the person's grip to the axis of a rod or of a crank's handle, or to the centre of a
 * stand. */
double sight_distance_m(const scene_t *scene, const scenario_t *scenario, size_t person, size_t object);

/* Writes "OBJECT.POINT", "PERSON's grip" or "the robot's gripper". */
void sight_name(const scenario_t *scenario, const point_t *point, char text[], size_t size);

#endif
