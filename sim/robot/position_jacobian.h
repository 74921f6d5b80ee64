/* Position Jacobian of the end effector, from the manual's kinematics (robot_model.h) in double precision. */
#ifndef COMANIP_SIM_POSITION_JACOBIAN_H
#define COMANIP_SIM_POSITION_JACOBIAN_H

#include <stdbool.h>

#include "robot_model.h"

/* Gives the position [m] of the end effector in the torso frame and J [m/rad], one row per joint. jacobian may be
 * NULL. */
void position_jacobian(const double position_rad[ROBOT_JOINTS], double hand_m[3], double jacobian[ROBOT_JOINTS][3]);

/* x = (J J^T + damping I)^-1 b over the free joints; is_free NULL: all. The matrix must be regular. damping is in
 * m^2. */
void position_jacobian_solve(const double jacobian[ROBOT_JOINTS][3], const bool is_free[ROBOT_JOINTS], double damping,
                             const double b[3], double x[3]);

#endif
