/* Turns a crank by hand: the hand follows the handle and keeps its orientation. */
#ifndef COMANIP_SIM_CRANK_TURN_H
#define COMANIP_SIM_CRANK_TURN_H

#include "../common/rigid_pose.h"

typedef struct {
    rigid_pose_t hinge; /* turns about its z axis; the handle is at its +x at angle 0 */
    double radius_m;
    double turns, turn_s; /* minimum_jerk.h */
    double begin_s;
    double start_rad;  /* angle of the handle at begin_s */
    rigid_pose_t here; /* pose of the hand at begin_s */
} crank_turn_t;

double crank_turn_duration_s(const crank_turn_t *self);
void crank_turn_sample(const crank_turn_t *self, double time_s, rigid_pose_t *pose);

/* Centre of the handle at an angle. */
void crank_handle(const rigid_pose_t *hinge, double radius_m, double angle_rad, double position_m[3]);

#endif
