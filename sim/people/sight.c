#include "sight.h"

#include <math.h>
#include <stdio.h>

#include "crank_turn.h"

double sight_crank_rad(const scene_t *scene, size_t object) {
    return 2.0 * ROBOT_PI * scene_crank_turns(scene, object);
}

double sight_distance_m(const scene_t *scene, const scenario_t *scenario, size_t person, size_t object) {
    const object_t *definition = &scenario->object[object];
    const point_t grip = {.kind = POINT_PERSON_GRIP, .index = person};
    rigid_pose_t centre;
    if (definition->kind == OBJECT_CRANK) {
        centre = definition->pose;
        crank_handle(&definition->pose, definition->radius_m, sight_crank_rad(scene, object), centre.position_m);
    } else {
        scene_object(scene, object, &centre);
    }
    rigid_pose_t seen = {.rotation = {1.0, 0.0, 0.0, 0.0}}; /* the grip in the frame of the object */
    scene_point(scene, &grip, seen.position_m);
    const rigid_pose_t torso = rigid_pose_inverse(&centre);
    seen = rigid_pose_multiply(&torso, &seen);
    const double half_m = definition->kind == OBJECT_STAND ? 0.0 : 0.5 * definition->length_m;
    const double beyond_end_m = fmax(fabs(seen.position_m[2]) - half_m, 0.0);
    return hypot(hypot(seen.position_m[0], seen.position_m[1]), beyond_end_m);
}

void sight_name(const scenario_t *scenario, const point_t *point, char text[], size_t size) {
    switch (point->kind) {
    case POINT_NONE: (void)snprintf(text, size, "nothing"); break;
    case POINT_OBJECT:
        (void)snprintf(text, size, "%s.%s", scenario->object[point->index].name,
                       scenario->object[point->index].point[point->point].name);
        break;
    case POINT_PERSON_GRIP: (void)snprintf(text, size, "%s's grip", scenario->person[point->index].name); break;
    case POINT_ROBOT_GRIPPER: (void)snprintf(text, size, "the robot's gripper"); break;
    }
}
