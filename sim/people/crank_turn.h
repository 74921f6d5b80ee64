/* The motion of a hand that turns a crank: it follows the handle and keeps its own orientation. */
#ifndef COMANIP_SIM_CRANK_TURN_H
#define COMANIP_SIM_CRANK_TURN_H

#include "../common/rigid_pose.h"

typedef struct {
    rigid_pose_t hinge; /* the crank turns about its z axis; at angle 0 the handle is on its +x axis */
    double radius_m;
    double turns, turn_s; /* arguments of smooth_turn_angle_rad() */
    double begin_s;
    double start_rad;  /* angle of the handle at begin_s */
    rigid_pose_t here; /* pose of the hand at begin_s */
} crank_turn_t;

double crank_turn_duration_s(const crank_turn_t *self);
void crank_turn_sample(const crank_turn_t *self, double time_s, rigid_pose_t *pose);

/* Computes the position of the handle's centre at an angle of the crank. */
void crank_handle(const rigid_pose_t *hinge, double radius_m, double angle_rad, double position_m[3]);

#endif
