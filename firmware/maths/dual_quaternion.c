/* Quaternions and dual quaternions: see dual_quaternion.h. */
#include "dual_quaternion.h"

#include "trigonometry.h"

const quaternion_t quaternion_identity = {1.0f, 0.0f, 0.0f, 0.0f};
const dual_quaternion_t dual_quaternion_identity = {{1.0f, 0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f, 0.0f}};

/* Square roots are correctly rounded, in hardware and in software, so every target computes the same bits. */
static float square_root(float x) {
    return __builtin_sqrtf(x);
}

/* Returns the pure quaternion t/2 of equation (2) for a translation t. */
static quaternion_t half_translation(vector3_t t_m) {
    return (quaternion_t){0.0f, 0.5f * t_m.x, 0.5f * t_m.y, 0.5f * t_m.z};
}

bool quaternion_is_unit(quaternion_t a, float tolerance) {
    float excess = quaternion_dot(a, a) - 1.0f; /* |a|^2 - 1 = 2 (|a| - 1) + ... */
    return excess > -2.0f * tolerance && excess < 2.0f * tolerance;
}

quaternion_t quaternion_normalise(quaternion_t a) {
    float norm_squared = quaternion_dot(a, a);
    if (norm_squared == 0.0f) {
        return quaternion_identity;
    }
    return quaternion_scale(a, 1.0f / square_root(norm_squared));
}

quaternion_t quaternion_align(quaternion_t a, quaternion_t reference) {
    return quaternion_dot(a, reference) < 0.0f ? quaternion_scale(a, -1.0f) : a;
}

quaternion_t quaternion_from_rotation_vector(vector3_t v_rad) {
    float angle_squared = v_rad.x * v_rad.x + v_rad.y * v_rad.y + v_rad.z * v_rad.z;
    if (angle_squared < 1e-12f) { /* the first-order quaternion is exact in float32 */
        return quaternion_normalise((quaternion_t){1.0f, 0.5f * v_rad.x, 0.5f * v_rad.y, 0.5f * v_rad.z});
    }
    float angle_rad = square_root(angle_squared);
    const sine_cosine_t half = sine_cosine(0.5f * angle_rad);
    float factor = half.sine / angle_rad;
    return (quaternion_t){half.cosine, factor * v_rad.x, factor * v_rad.y, factor * v_rad.z};
}

quaternion_t quaternion_from_matrix(const float matrix[9]) {
    const float xx = matrix[0], xy = matrix[1], xz = matrix[2];
    const float yx = matrix[3], yy = matrix[4], yz = matrix[5];
    const float zx = matrix[6], zy = matrix[7], zz = matrix[8];
    quaternion_t q;
    /* Each case computes 4 c q, where c is a component of q with c^2 at least 1/4, so that there is no cancellation. */
    if (xx + yy + zz > 0.0f) {
        q = (quaternion_t){1.0f + xx + yy + zz, zy - yz, xz - zx, yx - xy};
    } else if (xx >= yy && xx >= zz) {
        q = (quaternion_t){zy - yz, 1.0f + xx - yy - zz, xy + yx, xz + zx};
    } else if (yy >= zz) {
        q = (quaternion_t){xz - zx, xy + yx, 1.0f - xx + yy - zz, yz + zy};
    } else {
        q = (quaternion_t){yx - xy, xz + zx, yz + zy, 1.0f - xx - yy + zz};
    }
    q = quaternion_normalise(q);
    return q.w < 0.0f ? quaternion_scale(q, -1.0f) : q;
}

quaternion_t quaternion_interpolate(quaternion_t a, quaternion_t b, float s) {
    return quaternion_normalise(
        quaternion_add(quaternion_scale(a, 1.0f - s), quaternion_scale(quaternion_align(b, a), s)));
}

dual_quaternion_t dual_quaternion_add(dual_quaternion_t a, dual_quaternion_t b) {
    return (dual_quaternion_t){quaternion_add(a.primary, b.primary), quaternion_add(a.dual, b.dual)};
}

dual_quaternion_t dual_quaternion_negate(dual_quaternion_t a) {
    return (dual_quaternion_t){quaternion_scale(a.primary, -1.0f), quaternion_scale(a.dual, -1.0f)};
}

dual_quaternion_t dual_quaternion_multiply(dual_quaternion_t a, dual_quaternion_t b) {
    return (dual_quaternion_t){
        quaternion_multiply(a.primary, b.primary),
        quaternion_add(quaternion_multiply(a.primary, b.dual), quaternion_multiply(a.dual, b.primary)),
    };
}

dual_quaternion_t dual_quaternion_conjugate(dual_quaternion_t a) {
    return (dual_quaternion_t){quaternion_conjugate(a.primary), quaternion_conjugate(a.dual)};
}

dual_quaternion_t dual_quaternion_normalise(dual_quaternion_t a) {
    float norm_squared = quaternion_dot(a.primary, a.primary);
    if (norm_squared == 0.0f) {
        return dual_quaternion_identity;
    }
    float inverse_norm = 1.0f / square_root(norm_squared);
    quaternion_t primary = quaternion_scale(a.primary, inverse_norm);
    quaternion_t dual = quaternion_scale(a.dual, inverse_norm);
    /* The component of D along P does not belong to a translation, so it is removed. */
    return (dual_quaternion_t){primary,
                               quaternion_add(dual, quaternion_scale(primary, -quaternion_dot(primary, dual)))};
}

dual_quaternion_t dual_quaternion_from_pose(quaternion_t rotation, vector3_t translation_m) {
    return (dual_quaternion_t){rotation, quaternion_multiply(half_translation(translation_m), rotation)};
}

vector3_t dual_quaternion_translation(dual_quaternion_t pose) {
    quaternion_t half = quaternion_multiply(pose.dual, quaternion_conjugate(pose.primary));
    return (vector3_t){2.0f * half.x, 2.0f * half.y, 2.0f * half.z};
}

dual_quaternion_t dual_quaternion_decompositional_multiply(dual_quaternion_t a, dual_quaternion_t b) {
    vector3_t t_a = dual_quaternion_translation(a);
    vector3_t t_b = dual_quaternion_translation(b);
    return dual_quaternion_from_pose(quaternion_multiply(b.primary, a.primary),
                                     (vector3_t){t_a.x + t_b.x, t_a.y + t_b.y, t_a.z + t_b.z});
}

dual_quaternion_t dual_quaternion_align(dual_quaternion_t pose, dual_quaternion_t reference) {
    return quaternion_dot(pose.primary, reference.primary) < 0.0f ? dual_quaternion_negate(pose) : pose;
}
