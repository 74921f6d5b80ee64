#include "position_jacobian.h"

#include <stddef.h>

#include "../common/solve_3x3.h"

void position_jacobian(const double position_rad[ROBOT_JOINTS], double hand_m[3], double jacobian[ROBOT_JOINTS][3]) {
    transform_t link[ROBOT_JOINTS], hand;
    robot_model_forward(position_rad, link, &hand);
    for (size_t k = 0; k < 3; k++) {
        hand_m[k] = hand.position_m[k];
    }
    for (size_t i = 0; jacobian != NULL && i < ROBOT_JOINTS; i++) {
        const double axis[3] = {link[i].rotation[2], link[i].rotation[5], link[i].rotation[8]};
        double arm[3];
        for (size_t k = 0; k < 3; k++) {
            arm[k] = hand_m[k] - link[i].position_m[k];
        }
        jacobian[i][0] = axis[1] * arm[2] - axis[2] * arm[1];
        jacobian[i][1] = axis[2] * arm[0] - axis[0] * arm[2];
        jacobian[i][2] = axis[0] * arm[1] - axis[1] * arm[0];
    }
}

void position_jacobian_solve(const double jacobian[ROBOT_JOINTS][3], const bool is_free[ROBOT_JOINTS], double damping,
                             const double b[3], double x[3]) {
    double a[3][3] = {{0.0}};
    for (size_t i = 0; i < ROBOT_JOINTS; i++) {
        for (size_t row = 0; (is_free == NULL || is_free[i]) && row < 3; row++) {
            for (size_t column = 0; column < 3; column++) {
                a[row][column] += jacobian[i][row] * jacobian[i][column];
            }
        }
    }
    solve_3x3(a, damping, b, x);
}
