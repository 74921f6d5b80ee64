/* Position Jacobian of the end effector, from the manual's kinematics (robot_model.h) in double precision. */
#ifndef COMANIP_SIM_POSITION_JACOBIAN_H
#define COMANIP_SIM_POSITION_JACOBIAN_H

#include <stdbool.h>

#include "robot_model.h"

/* Computes the position [m] of the end effector in the torso frame, and the transpose of its Jacobian [m/rad], with one
 * row per joint. jacobian may be NULL. */
void position_jacobian(const double position_rad[ROBOT_JOINTS], double hand_m[3], double jacobian[ROBOT_JOINTS][3]);

/* Solves (J J^T + damping I) x = b, where J has the columns of the free joints only. All joints are free if is_free is
 * NULL. The matrix must be invertible. damping is in m^2. */
void position_jacobian_solve(const double jacobian[ROBOT_JOINTS][3], const bool is_free[ROBOT_JOINTS], double damping,
                             const double b[3], double x[3]);

#endif
