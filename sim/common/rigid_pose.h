/* Poses and rotations of the simulated world, in double precision. Rotations are unit quaternions w x y z, multiplied
 * by the Hamilton product. */
#ifndef COMANIP_SIM_RIGID_POSE_H
#define COMANIP_SIM_RIGID_POSE_H

typedef struct {
    double position_m[3];
    double rotation[4]; /* unit quaternion w x y z */
} rigid_pose_t;

void rotation_multiply(const double a[4], const double b[4], double product[4]);
void rotation_apply(const double rotation[4], const double v[3], double rotated[3]);

/* Returns the angle [rad] of the rotation from a to b, 0 to pi. q and -q are the same rotation. */
double rotation_angle_between(const double a[4], const double b[4]);

double rotation_dot(const double a[4], const double b[4]);

/* Scales to unit norm. A zero quaternion is left unchanged. */
void rotation_normalise(double rotation[4]);

/* Sets `rotation` to a rotation by |v| rad about v. */
void rotation_from_vector(const double v_rad[3], double rotation[4]);

/* Converts a rotation matrix to a quaternion (footnote 1 of the paper). The matrix must be orthonormal with determinant
 * 1. */
void rotation_from_matrix(const double matrix[3][3], double rotation[4]);

/* Interpolates spherically from a (fraction 0) to b (fraction 1). Requires <a, b> >= 0. */
void rotation_interpolate(const double a[4], const double b[4], double fraction, double rotation[4]);

/* Returns the pose of frame c in frame a, given the pose of b in a and the pose of c in b. */
rigid_pose_t rigid_pose_multiply(const rigid_pose_t *a_to_b, const rigid_pose_t *b_to_c);
rigid_pose_t rigid_pose_inverse(const rigid_pose_t *pose);

/* Interpolates linearly in position and spherically in rotation. */
void rigid_pose_interpolate(const rigid_pose_t *a, const rigid_pose_t *b, double fraction, rigid_pose_t *pose);

/* Flips the sign of the quaternion, which leaves the rotation unchanged, if that brings it closer to `reference`. */
void rigid_pose_choose_side(rigid_pose_t *pose, const rigid_pose_t *reference);

#endif
