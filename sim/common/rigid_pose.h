/* Poses and rotations of the simulated world in double precision: unit quaternions w x y z, Hamilton product. */
#ifndef COMANIP_SIM_RIGID_POSE_H
#define COMANIP_SIM_RIGID_POSE_H

typedef struct {
    double position_m[3];
    double rotation[4]; /* unit quaternion w x y z */
} rigid_pose_t;

void rotation_multiply(const double a[4], const double b[4], double product[4]);
void rotation_apply(const double rotation[4], const double v[3], double rotated[3]);

/* Angle [rad] of the rotation from a to b, 0..pi; the double cover does not matter. */
double rotation_angle_between(const double a[4], const double b[4]);

double rotation_dot(const double a[4], const double b[4]);

/* A zero quaternion stays as it is. */
void rotation_normalise(double rotation[4]);

/* By |v| rad about v. */
void rotation_from_vector(const double v_rad[3], double rotation[4]);

/* Footnote 1 of the paper. The matrix must be a rotation. */
void rotation_from_matrix(const double matrix[3][3], double rotation[4]);

/* Great circle from a (fraction 0) to b (1); b must lie on a's side, <a, b> >= 0. */
void rotation_interpolate(const double a[4], const double b[4], double fraction, double rotation[4]);

/* Frame c seen from a, given b seen from a and c seen from b. */
rigid_pose_t rigid_pose_multiply(const rigid_pose_t *a_to_b, const rigid_pose_t *b_to_c);
rigid_pose_t rigid_pose_inverse(const rigid_pose_t *pose);

/* Linear in position, along the great circle in rotation. */
void rigid_pose_interpolate(const rigid_pose_t *a, const rigid_pose_t *b, double fraction, rigid_pose_t *pose);

/* The other sign of the quaternion, which is the same rotation, if it is nearer to that of `reference`. */
void rigid_pose_choose_side(rigid_pose_t *pose, const rigid_pose_t *reference);

#endif
