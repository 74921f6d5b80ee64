/* How the hand's position changes with the joints, on the manual's kinematics (robot_model.h) in double. */
#ifndef COMANIP_SIM_POSITION_JACOBIAN_H
#define COMANIP_SIM_POSITION_JACOBIAN_H

#include <stdbool.h>

#include "robot_model.h"

/* The hand's position [m] in the torso frame, and J [m/rad], joint by joint; jacobian may be NULL. */
void position_jacobian(const double position_rad[ROBOT_JOINTS], double hand_m[3], double jacobian[ROBOT_JOINTS][3]);

/* x = (J J^T + damping 1)^-1 b over the free joints; is_free NULL: all. damping [m^2] must keep it regular. */
void position_jacobian_solve(const double jacobian[ROBOT_JOINTS][3], const bool is_free[ROBOT_JOINTS], double damping,
                             const double b[3], double x[3]);

#endif
