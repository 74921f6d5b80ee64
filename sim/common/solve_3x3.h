/* Solves three linear equations with a symmetric matrix. */
#ifndef COMANIP_SIM_SOLVE_3X3_H
#define COMANIP_SIM_SOLVE_3X3_H

/* Computes x = (A + damping I)^-1 b for a symmetric positive semidefinite A. A + damping I must be invertible. */
void solve_3x3(double a[3][3], double damping, const double b[3], double x[3]);

#endif
