/* Quaternions and dual quaternions, the algebra of the paper (sections III and IV-A).
 *
 * Conventions: Hamilton product, order w x y z, float32, SI units. A pose is the unit dual quaternion
 * x = r + eps 1/2 t r with rotation r and translation t [m] (equation (2)); its 8 floats are stored as
 * [rw rx ry rz dw dx dy dz], the paper's vec8. x and -x represent the same pose.
 *
 * All functions take and return structs by value, and accept any input; a NaN in the input yields a NaN in the result.
 * If the inputs are unit, the result is unit within rounding; only the functions that say so normalise it. */
#ifndef COMANIP_DUAL_QUATERNION_H
#define COMANIP_DUAL_QUATERNION_H

#include <stdbool.h>

typedef struct {
    float x, y, z;
} vector3_t;

typedef struct {
    float w, x, y, z;
} quaternion_t;

typedef struct {
    quaternion_t primary; /* P(x): the rotation of a pose */
    quaternion_t dual;    /* D(x) */
} dual_quaternion_t;

extern const quaternion_t quaternion_identity;
extern const dual_quaternion_t dual_quaternion_identity;

static inline vector3_t vector3_add(vector3_t a, vector3_t b) {
    return (vector3_t){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline vector3_t vector3_scale(vector3_t a, float factor) {
    return (vector3_t){a.x * factor, a.y * factor, a.z * factor};
}
static inline vector3_t vector3_cross(vector3_t a, vector3_t b) {
    return (vector3_t){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline float vector3_dot(vector3_t a, vector3_t b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline quaternion_t quaternion_add(quaternion_t a, quaternion_t b) {
    return (quaternion_t){a.w + b.w, a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline quaternion_t quaternion_scale(quaternion_t a, float factor) {
    return (quaternion_t){a.w * factor, a.x * factor, a.y * factor, a.z * factor};
}
static inline quaternion_t quaternion_multiply(quaternion_t a, quaternion_t b) {
    return (quaternion_t){
        a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
    };
}
static inline quaternion_t quaternion_conjugate(quaternion_t a) {
    return (quaternion_t){a.w, -a.x, -a.y, -a.z};
}
static inline float quaternion_dot(quaternion_t a, quaternion_t b) {
    return a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
}

/* Returns true if | |a| - 1 | is below the tolerance, to first order; false for NaN. */
bool quaternion_is_unit(quaternion_t a, float tolerance);

/* Returns a / |a|, or the identity for the zero quaternion. */
quaternion_t quaternion_normalise(quaternion_t a);

/* Returns whichever of a and -a, which are the same rotation, has a dot product >= 0 with the reference. */
quaternion_t quaternion_align(quaternion_t a, quaternion_t reference);

/* Rotates a vector by a unit quaternion: r v conj(r) = (w^2 - u . u) v + 2 (u . v) u + 2 w u x v, where u is the vector
 * part. In this form, a rounding error in the quaternion's norm changes the result's length but not its direction. */
static inline vector3_t quaternion_rotate(quaternion_t rotation, vector3_t v) {
    const vector3_t r = {rotation.x, rotation.y, rotation.z};
    const vector3_t straight = vector3_scale(v, rotation.w * rotation.w - vector3_dot(r, r));
    const vector3_t along = vector3_scale(r, 2.0f * vector3_dot(r, v));
    const vector3_t across = vector3_scale(vector3_cross(r, v), 2.0f * rotation.w);
    return vector3_add(vector3_add(straight, along), across);
}

/* Returns the rotation by the angle |v| [rad] about v / |v|, or the identity for zero. |v| must be within
 * TRIGONOMETRY_MAX_RAD. */
quaternion_t quaternion_from_rotation_vector(vector3_t v_rad);

/* Returns the unit quaternion with w >= 0 of a rotation matrix, given row by row (the paper's footnote 1). The result
 * is computed from a component of magnitude 1/2 or more, so that no rotation loses precision. The matrix must be a
 * rotation within rounding. */
quaternion_t quaternion_from_matrix(const float matrix[9]);

/* Interpolates linearly from a (s = 0) to b (s = 1) along the shorter path, and normalises. */
quaternion_t quaternion_interpolate(quaternion_t a, quaternion_t b, float s);

dual_quaternion_t dual_quaternion_add(dual_quaternion_t a, dual_quaternion_t b);
dual_quaternion_t dual_quaternion_negate(dual_quaternion_t a);
dual_quaternion_t dual_quaternion_multiply(dual_quaternion_t a, dual_quaternion_t b);

/* Conjugates both quaternions, which yields the inverse of a unit dual quaternion. */
dual_quaternion_t dual_quaternion_conjugate(dual_quaternion_t a);

/* Normalises to a pose, so that |P| = 1 and P . D = 0. Returns the identity if the primary part is zero. */
dual_quaternion_t dual_quaternion_normalise(dual_quaternion_t a);

/* Returns r + eps 1/2 t r for a unit rotation r and a translation t [m] (footnote 1 of the paper). */
dual_quaternion_t dual_quaternion_from_pose(quaternion_t rotation, vector3_t translation_m);

/* Returns the translation t [m] of a pose, 2 D conj(P). */
vector3_t dual_quaternion_translation(dual_quaternion_t pose);

/* Definition 2, equation (6): a (x) b = T{b} T{a} P(b) P(a). Translations add, and rotations compose as P(b) P(a). */
dual_quaternion_t dual_quaternion_decompositional_multiply(dual_quaternion_t a, dual_quaternion_t b);

/* Returns whichever of x = pose and x = -pose, which are the same pose, satisfies P(x) . P(reference) >= 0. */
dual_quaternion_t dual_quaternion_align(dual_quaternion_t pose, dual_quaternion_t reference);

#endif
