#include "scenario_geometry.h"

#include <math.h>
#include <stdio.h>

#include "../proximity/convex_shape.h"

#define CONTACT_M 0.001 /* a rod that rests on a stand may overlap it by so much */
#define START_RANGE_M 2.0
#define SPEED_MAX_MPS 5.0
#define PEAK_OF_MINIMUM_JERK 1.875 /* peak speed over mean speed */
#define PACKING_MAX 0.64 /* volume of spheres over the cup's: random close packing */

static bool check_posture(const scenario_t *self, char error[], size_t error_size) {
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        const double minimum_deg = robot_model_position_min_rad(i) / ROBOT_RAD_PER_DEG;
        const double maximum_deg = robot_model_position_max_rad(i) / ROBOT_RAD_PER_DEG;
        if (self->start_deg[i] < minimum_deg || self->start_deg[i] > maximum_deg) {
            (void)snprintf(error, error_size,
                           "%s: arm.start_deg '%g': the arm cannot reach it; expected %g to %g deg for joint %d",
                           self->path, self->start_deg[i], minimum_deg, maximum_deg, i);
            return false;
        }
    }
    return true;
}

static bool check_people(const scenario_t *self, char error[], size_t error_size) {
    for (size_t i = 0; i < self->person_count; i++) {
        const person_t *person = &self->person[i];
        const double *p = person->start.position_m;
        const double distance_m = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        if (distance_m > START_RANGE_M) {
            (void)snprintf(error, error_size,
                           "%s: people.%s.position_m: %g m from the torso; expected at most %g m (are the numbers in m?)",
                           self->path, person->name, distance_m, START_RANGE_M);
            return false;
        }
        const double *from_m = NULL;
        const double home_m[3] = {0.0, 0.0, 0.0};
        for (size_t j = 0; j < person->step_count; j++) {
            const person_step_t *step = &person->step[j];
            if (step->action != PERSON_MOVE) {
                from_m = NULL; /* where the hand is then, is not known beforehand */
                continue;
            }
            const double *start_m = step->from_here ? home_m : from_m != NULL ? from_m : j == 0 ? home_m : NULL;
            const double *end_m = step->displacement_m;
            from_m = step->from_here ? NULL : end_m;
            if (start_m == NULL) {
                continue;
            }
            const double way_m = sqrt(pow(end_m[0] - start_m[0], 2) + pow(end_m[1] - start_m[1], 2) +
                                      pow(end_m[2] - start_m[2], 2));
            const double speed_mps = PEAK_OF_MINIMUM_JERK * way_m / step->duration_s;
            if (speed_mps > SPEED_MAX_MPS) {
                (void)snprintf(error, error_size,
                               "%s: people.%s.program: a move of %g m in %g s reaches %.3g m/s; expected at most %g m/s",
                               self->path, person->name, way_m, step->duration_s, speed_mps, SPEED_MAX_MPS);
                return false;
            }
        }
    }
    return true;
}

static bool check_water(const scenario_t *self, char error[], size_t error_size) {
    if (self->water.particles == 0) {
        return true;
    }
    const double r = self->water.particle_radius_m, radius_m = self->cup.radius_m;
    const double cup_m3 = ROBOT_PI * radius_m * radius_m * self->cup.height_m;
    const double water_m3 = self->water.particles * 4.0 / 3.0 * ROBOT_PI * r * r * r;
    if (r >= radius_m || water_m3 > PACKING_MAX * cup_m3) {
        (void)snprintf(error, error_size,
                       "%s: water.particles '%d': they do not fit the robot's cup; expected at most %d of this radius",
                       self->path, self->water.particles,
                       r < radius_m ? (int)(self->water.particles * PACKING_MAX * cup_m3 / water_m3) : 0);
        return false;
    }
    return true;
}

/* Crank: its handle. */
static void object_shape(const object_t *object, convex_shape_t *shape) {
    *shape = (convex_shape_t){.kind = SHAPE_CYLINDER, .length_m = object->length_m, .radius_m = object->radius_m,
                              .pose = object->pose};
    if (object->kind == OBJECT_STAND) {
        shape->kind = SHAPE_BOX;
        for (int k = 0; k < 3; k++) {
            shape->size_m[k] = object->size_m[k];
        }
    } else if (object->kind == OBJECT_CRANK) {
        const rigid_pose_t offset = {{object->radius_m, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}};
        shape->radius_m = 0.01;
        shape->pose = rigid_pose_multiply(&object->pose, &offset);
    }
    convex_shape_finish(shape);
}

static bool check_objects(const scenario_t *self, char error[], size_t error_size) {
    for (size_t i = 0; i < self->object_count; i++) {
        for (size_t j = 0; j < i; j++) {
            convex_shape_t a, b;
            object_shape(&self->object[i], &a);
            object_shape(&self->object[j], &b);
            const double overlap_m = convex_overlap_m(&a, &b);
            if (overlap_m > CONTACT_M) {
                (void)snprintf(error, error_size,
                               "%s: objects.%s.position_m: it is %.1f mm inside %s; expected at most %g mm",
                               self->path, self->object[i].name, 1e3 * overlap_m, self->object[j].name,
                               1e3 * CONTACT_M);
                return false;
            }
        }
    }
    return true;
}

/* Of the gripper's middle from the axis of what it is said to hold. */
static double distance_from_gripper_m(const scenario_t *self, const object_t *object) {
    double start_rad[ROBOT_JOINTS], axis[3], along_m = 0.0, square_m2 = 0.0;
    const double z[3] = {0.0, 0.0, 1.0};
    transform_t hand;
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        start_rad[i] = self->start_deg[i] * ROBOT_RAD_PER_DEG;
    }
    robot_model_forward(start_rad, NULL, &hand);
    rotation_apply(object->pose.rotation, z, axis);
    double way_m[3];
    for (int k = 0; k < 3; k++) {
        const double *row = &hand.rotation[3 * k], *offset = self->gripper.offset_m;
        way_m[k] = hand.position_m[k] + row[0] * offset[0] + row[1] * offset[1] + row[2] * offset[2] -
                   object->pose.position_m[k];
        along_m += way_m[k] * axis[k];
    }
    along_m = fmax(-0.5 * object->length_m, fmin(0.5 * object->length_m, along_m));
    for (int k = 0; k < 3; k++) {
        square_m2 += (way_m[k] - along_m * axis[k]) * (way_m[k] - along_m * axis[k]);
    }
    return sqrt(square_m2);
}

static bool check_held(const scenario_t *self, char error[], size_t error_size) {
    size_t held = 0;
    for (size_t i = 0; i < self->object_count; i++) {
        const object_t *object = &self->object[i];
        const double distance_m = object->held_by_robot ? distance_from_gripper_m(self, object) : 0.0;
        held += object->held_by_robot;
        if (distance_m > self->gripper.capture_m || held > 1) {
            (void)snprintf(error, error_size,
                           "%s: objects.%s.held_by 'robot': %s; expected its axis within %g mm of the gripper's middle",
                           self->path, object->name, held > 1 ? "the gripper holds another" : "it is not in the gripper",
                           1e3 * self->gripper.capture_m);
            return false;
        }
    }
    return true;
}

bool scenario_check_geometry(const scenario_t *self, char error[], size_t error_size) {
    return check_posture(self, error, error_size) && check_people(self, error, error_size) &&
           check_water(self, error, error_size) && check_objects(self, error, error_size) &&
           check_held(self, error, error_size);
}
