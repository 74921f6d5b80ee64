/* What a person sees of the scene beside its points: the handle's angle, how far an object is, and what things are
 * called. */
#ifndef COMANIP_SIM_SIGHT_H
#define COMANIP_SIM_SIGHT_H

#include "../scene/scene.h"

/* Of the crank's handle, 0 at its start. */
double sight_crank_rad(const scene_t *scene, size_t object);

/* From the person's grip to the axis of the rod, to that of the crank's handle, or to the middle of a stand. */
double sight_distance_m(const scene_t *scene, const scenario_t *scenario, size_t person, size_t object);

/* "OBJECT.POINT", "PERSON's grip" or "the robot's gripper". */
void sight_name(const scenario_t *scenario, const point_t *point, char text[], size_t size);

#endif
