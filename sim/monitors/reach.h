/* Tests whether the arm can reach a position, with the manual's kinematics in double precision and without the
 * firmware. */
#ifndef COMANIP_SIM_REACH_H
#define COMANIP_SIM_REACH_H

#include <stdbool.h>

#include "../robot/robot_model.h"

#define REACH_TOLERANCE_M                                                                                              \
    0.001 /* a position is in reach if some posture within the limits is this close                         \
           */

#define REACH_GRID 6 /* angles per joint, including the joint limits */
#define REACH_POSTURES (REACH_GRID * REACH_GRID * REACH_GRID * REACH_GRID)

typedef struct {
    double hand_m[REACH_POSTURES][3];  /* of a grid of postures; a search starts at those near the target */
    double position_rad[ROBOT_JOINTS]; /* best posture for the last target, start of the next search */
    bool searched;
    double target_m[3]; /* of the last search */
    double distance_m;  /* result of the last search */
} reach_t;

void reach_init(reach_t *self);

/* Returns the smallest distance [m] found between the end effector and target_m over all postures within the joint
 * limits, with free orientation. Damped Gauss-Newton with projection onto the limits starts from the last solution,
 * from measured_rad and, if these fail, from the closest postures of a grid. It ends as soon as the distance is below
 * REACH_TOLERANCE_M / 10. */
double reach_distance_m(reach_t *self, const double target_m[3], const double measured_rad[ROBOT_JOINTS]);

/* Returns true if this distance is within REACH_TOLERANCE_M. Searches only if the last result does not decide it: if
 * the target moves by s metres, the smallest distance changes by at most s. */
bool reach_contains(reach_t *self, const double target_m[3], const double measured_rad[ROBOT_JOINTS]);

#endif
