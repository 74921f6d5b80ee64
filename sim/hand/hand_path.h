/* A minimum-jerk move of the hand from one pose to another, along a straight line or an arc, by the shorter
 * rotation. */
#ifndef COMANIP_SIM_HAND_PATH_H
#define COMANIP_SIM_HAND_PATH_H

#include "../common/rigid_pose.h"

typedef struct {
    rigid_pose_t from, to; /* to: quaternion sign nearest to that of from */
    double bow_m[3];       /* offset of the midpoint from the straight line */
    double begin_s, duration_s;
} hand_path_t;

/* bow_m NULL: a straight line. duration_s 0: the hand is at `to` at once. */
void hand_path_init(hand_path_t *self, const rigid_pose_t *from, const rigid_pose_t *to, const double bow_m[3],
                    double begin_s, double duration_s);

/* Returns `from` before the move begins and `to` after it ends. */
void hand_path_sample(const hand_path_t *self, double time_s, rigid_pose_t *pose);

#endif
