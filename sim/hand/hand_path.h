/* A move of the hand from one pose to another: minimum jerk, on a straight line or a bow, the shorter way round. */
#ifndef COMANIP_SIM_HAND_PATH_H
#define COMANIP_SIM_HAND_PATH_H

#include "../common/rigid_pose.h"

typedef struct {
    rigid_pose_t from, to; /* to: its quaternion on from's side */
    double bow_m[3];       /* so far off the straight line is the middle of the way */
    double begin_s, duration_s;
} hand_path_t;

/* bow_m: NULL: straight. duration_s 0: it is there at once. */
void hand_path_init(hand_path_t *self, const rigid_pose_t *from, const rigid_pose_t *to, const double bow_m[3],
                    double begin_s, double duration_s);

/* Before its begin the first pose, after its end the last. */
void hand_path_sample(const hand_path_t *self, double time_s, rigid_pose_t *pose);

#endif
