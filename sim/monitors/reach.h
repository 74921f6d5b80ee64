/* Can the arm reach a position at all? On the manual's kinematics in double; knows nothing of the firmware. */
#ifndef COMANIP_SIM_REACH_H
#define COMANIP_SIM_REACH_H

#include <stdbool.h>

#include "../robot/robot_model.h"

#define REACH_TOLERANCE_M                                                                                              \
    0.001 /* a position is in reach if some posture within the limits puts the hand this close                         \
           */

#define REACH_GRID 6 /* angles per joint, the ends of its range among them */
#define REACH_POSTURES (REACH_GRID * REACH_GRID * REACH_GRID * REACH_GRID)

typedef struct {
    double hand_m[REACH_POSTURES][3];  /* of a grid of postures: those next to a target are where to search */
    double position_rad[ROBOT_JOINTS]; /* best posture for the last target: where the next search starts */
    bool searched;
    double target_m[3]; /* of the last search */
    double distance_m;  /* its outcome */
} reach_t;

void reach_init(reach_t *self);

/* Least distance [m] found between the hand and target_m over all postures within the usable range, orientation free:
 * damped Gauss-Newton with projection onto the range, from the last solution, from measured_rad and, if these fail,
 * from the postures of a grid that come closest. Ends as soon as REACH_TOLERANCE_M / 10 is met. */
double reach_distance_m(reach_t *self, const double target_m[3], const double measured_rad[ROBOT_JOINTS]);

/* That distance is within REACH_TOLERANCE_M. Searches only if the last outcome leaves it open: on a way of s metres the
 * least distance changes by at most s. */
bool reach_contains(reach_t *self, const double target_m[3], const double measured_rad[ROBOT_JOINTS]);

#endif
