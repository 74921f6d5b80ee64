/* Rotations in double for the simulator: unit quaternions w x y z, Hamilton product. */
#ifndef COMANIP_SIM_ROTATION_H
#define COMANIP_SIM_ROTATION_H

void rotation_multiply(const double a[4], const double b[4], double product[4]);
void rotation_apply(const double rotation[4], const double v[3], double rotated[3]);

/* Angle [rad] of the rotation from a to b, 0..pi; the double cover does not matter. */
double rotation_angle_between(const double a[4], const double b[4]);

#endif
