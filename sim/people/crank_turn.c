#include "crank_turn.h"

#include <math.h>

#include "../hand/minimum_jerk.h"

void crank_handle(const rigid_pose_t *hinge, double radius_m, double angle_rad, double position_m[3]) {
    const double arm_m[3] = {radius_m * cos(angle_rad), radius_m * sin(angle_rad), 0.0};
    rotation_apply(hinge->rotation, arm_m, position_m);
    for (int i = 0; i < 3; i++) {
        position_m[i] += hinge->position_m[i];
    }
}

double crank_turn_duration_s(const crank_turn_t *self) {
    return smooth_turn_duration_s(self->turns, self->turn_s);
}

void crank_turn_sample(const crank_turn_t *self, double time_s, rigid_pose_t *pose) {
    double start_m[3], handle_m[3];
    const double turned_rad = smooth_turn_angle_rad(self->turns, self->turn_s, time_s - self->begin_s);
    crank_handle(&self->hinge, self->radius_m, self->start_rad, start_m);
    crank_handle(&self->hinge, self->radius_m, self->start_rad + turned_rad, handle_m);
    *pose = self->here;
    for (int i = 0; i < 3; i++) {
        pose->position_m[i] += handle_m[i] - start_m[i];
    }
}
