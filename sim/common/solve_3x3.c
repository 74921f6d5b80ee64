#include "solve_3x3.h"

/* Cramer's rule with cofactors. */
void solve_3x3(double a[3][3], double damping, const double b[3], double x[3]) {
    const double a00 = a[0][0] + damping, a11 = a[1][1] + damping, a22 = a[2][2] + damping;
    const double a01 = a[0][1], a02 = a[0][2], a12 = a[1][2];
    const double c00 = a11 * a22 - a12 * a12, c01 = a02 * a12 - a01 * a22, c02 = a01 * a12 - a02 * a11;
    const double c11 = a00 * a22 - a02 * a02, c12 = a01 * a02 - a00 * a12, c22 = a00 * a11 - a01 * a01;
    const double determinant = a00 * c00 + a01 * c01 + a02 * c02;
    x[0] = (c00 * b[0] + c01 * b[1] + c02 * b[2]) / determinant;
    x[1] = (c01 * b[0] + c11 * b[1] + c12 * b[2]) / determinant;
    x[2] = (c02 * b[0] + c12 * b[1] + c22 * b[2]) / determinant;
}
