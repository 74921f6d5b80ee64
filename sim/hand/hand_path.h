/* A minimum-jerk move of the hand from one pose to another, along a straight line or an arc, with the shorter of the
 * two possible rotations. */
#ifndef COMANIP_SIM_HAND_PATH_H
#define COMANIP_SIM_HAND_PATH_H

#include "../common/rigid_pose.h"

typedef struct {
    rigid_pose_t from, to; /* the quaternion of `to` is the one of q and -q that is closer to that of `from` */
    double bow_m[3];       /* offset of the path's midpoint from the straight line */
    double begin_s, duration_s;
} hand_path_t;

/* Prepares a move. If bow_m is NULL, the path is straight. If duration_s is 0, the hand is at `to` at once. */
void hand_path_init(hand_path_t *self, const rigid_pose_t *from, const rigid_pose_t *to, const double bow_m[3],
                    double begin_s, double duration_s);

/* Sets pose to the hand's pose at time_s: `from` before the move begins and `to` after it ends. */
void hand_path_sample(const hand_path_t *self, double time_s, rigid_pose_t *pose);

#endif
