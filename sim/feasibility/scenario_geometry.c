#include "scenario_geometry.h"

#include <math.h>
#include <stdio.h>

#define START_RANGE_M 2.0

static bool check_people(const scenario_t *self, char error[], size_t error_size) {
    for (size_t i = 0; i < self->person_count; i++) {
        const double *p = self->person[i].start.position_m;
        const double distance_m = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        if (distance_m > START_RANGE_M) {
            (void)snprintf(error, error_size,
                           "%s: people.%s.position_m '[%g, %g, %g]': expected at most %g m from the torso; are the "
                           "numbers in m?",
                           self->path, self->person[i].name, p[0], p[1], p[2], START_RANGE_M);
            return false;
        }
    }
    return true;
}

/* Returns the distance of the gripper's centre from the axis of the object that it should hold. */
static double distance_from_gripper_m(const scenario_t *self, const object_t *object) {
    double start_rad[ROBOT_JOINTS], axis[3], along_m = 0.0, square_m2 = 0.0;
    const double z[3] = {0.0, 0.0, 1.0};
    transform_t hand;
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        start_rad[i] = self->start_deg[i] * ROBOT_RAD_PER_DEG;
    }
    robot_model_forward(start_rad, NULL, &hand);
    rotation_apply(object->pose.rotation, z, axis);
    double from_object_m[3];
    for (int k = 0; k < 3; k++) {
        const double *row = &hand.rotation[3 * k], *offset = self->gripper.offset_m;
        from_object_m[k] = hand.position_m[k] + row[0] * offset[0] + row[1] * offset[1] + row[2] * offset[2] -
                           object->pose.position_m[k];
        along_m += from_object_m[k] * axis[k];
    }
    along_m = fmax(-0.5 * object->length_m, fmin(0.5 * object->length_m, along_m));
    for (int k = 0; k < 3; k++) {
        square_m2 += (from_object_m[k] - along_m * axis[k]) * (from_object_m[k] - along_m * axis[k]);
    }
    return sqrt(square_m2);
}

static bool check_held(const scenario_t *self, char error[], size_t error_size) {
    const object_t *held = NULL;
    for (size_t i = 0; i < self->object_count; i++) {
        const object_t *object = &self->object[i];
        if (!object->held_by_robot) {
            continue;
        }
        if (held != NULL) {
            (void)snprintf(error, error_size,
                           "%s: objects.%s.held_by 'robot': expected at most one such object; %s is also held by the "
                           "robot",
                           self->path, object->name, held->name);
            return false;
        }
        held = object;
        const double distance_m = distance_from_gripper_m(self, object);
        if (distance_m > self->gripper.capture_m) {
            (void)snprintf(error, error_size,
                           "%s: objects.%s.held_by 'robot': expected its axis within %g mm of the gripper's centre; it "
                           "is %.1f mm away",
                           self->path, object->name, 1e3 * self->gripper.capture_m, 1e3 * distance_m);
            return false;
        }
    }
    return true;
}

bool scenario_check_geometry(const scenario_t *self, char error[], size_t error_size) {
    return check_people(self, error, error_size) && check_held(self, error, error_size) &&
           scenario_check_motion(self, error, error_size) && scenario_check_overlap(self, error, error_size);
}
