/* Tests whether the arm can reach a position. Uses the kinematics of the robot's manual in double precision, and no
 * code of the firmware. */
#ifndef COMANIP_SIM_REACH_H
#define COMANIP_SIM_REACH_H

#include <stdbool.h>

#include "../robot/robot_model.h"

/* A position is in reach if, in some posture within the limits, the distance of the end effector from the position is
 * at most this. */
#define REACH_TOLERANCE_M 0.001

#define REACH_GRID 6 /* angles per joint, including the joint limits */
#define REACH_POSTURES (REACH_GRID * REACH_GRID * REACH_GRID * REACH_GRID)

typedef struct {
    double hand_m[REACH_POSTURES][3];  /* end effector at each posture of a grid; searches start near the target */
    double position_rad[ROBOT_JOINTS]; /* best posture for the last target, from which the next search starts */
    bool searched;
    double target_m[3]; /* target of the last search */
    double distance_m;  /* result of the last search */
} reach_t;

void reach_init(reach_t *self);

/* Returns the smallest distance [m] found between the end effector and target_m over all postures within the joint
 * limits, with free orientation. The search is a damped Gauss-Newton method with projection onto the limits. It starts
 * from the last solution and, if that fails, from measured_rad and then from the closest postures of a grid. Each
 * descent ends as soon as the distance is below REACH_TOLERANCE_M / 10. */
double reach_distance_m(reach_t *self, const double target_m[3], const double measured_rad[ROBOT_JOINTS]);

/* Returns true if the result of reach_distance_m() is at most REACH_TOLERANCE_M. Does not search if the result of the
 * last search already decides the answer: if the target has moved by s metres since then, the smallest distance has
 * changed by at most s metres. */
bool reach_contains(reach_t *self, const double target_m[3], const double measured_rad[ROBOT_JOINTS]);

#endif
