/* Made by `make arms` from hoap3_right.toml: edit that. How: host_tools/comanip/arm_law.py. */
#include "hoap3_right.h"

#include "../joint_ends.h"
#include "../trigonometry_inline.h"
#include "../velocity_control.h"
#include "../velocity_control_general.h"

static const arm_joint_t joints[4] = {
    {{{0.707106781f, -0.707106781f, 0.0f, 0.0f}, {-0.035f, -0.111f, 0.125f}}, {0.0f, 0.0f, 1.0f}, -1.57079633f, 2.61799388f, 4.76f, 10000.0f},
    {{{0.5f, 0.5f, -0.5f, 0.5f}, {0.0f, 0.0f, 0.0f}}, {0.0f, 0.0f, 1.0f}, -1.65806279f, 0.0f, 4.76f, 10000.0f},
    {{{0.5f, 0.5f, -0.5f, 0.5f}, {0.0f, -0.111f, 0.0f}}, {0.0f, 0.0f, 1.0f}, -1.57079633f, 1.57079633f, 4.76f, 10000.0f},
    {{{0.707106781f, 0.707106781f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}}, {0.0f, 0.0f, 1.0f}, -1.98967535f, 0.0f, 4.76f, 10000.0f},
};

/* arm_forward_kinematics() for this arm. */
static pose_t forward_kinematics(const arm_t *arm, const float position_rad[]) {
    (void)arm;
    const sine_cosine_t half_0 = sine_cosine(0.5f * position_rad[0]);
    const sine_cosine_t half_1 = sine_cosine(0.5f * position_rad[1]);
    const sine_cosine_t half_2 = sine_cosine(0.5f * position_rad[2]);
    const sine_cosine_t half_3 = sine_cosine(0.5f * position_rad[3]);
    const float m0 = 2.0f * half_0.sine;
    const float m1 = m0 * half_0.sine;
    const float m2 = m1 - 1.0f;
    const float m3 = m0 * half_0.cosine;
    const float m4 = 2.0f * half_1.sine;
    const float m5 = m4 * half_1.sine;
    const float m6 = m5 - 1.0f;
    const float m7 = m4 * half_1.cosine;
    const float m8 = half_1.cosine - half_1.sine;
    const float m9 = half_1.cosine + half_1.sine;
    const float m10 = 2.0f * half_2.sine;
    const float m11 = m10 * half_2.sine;
    const float m12 = m11 - 1.0f;
    const float m13 = m10 * half_2.cosine;
    const float m14 = half_2.cosine - half_2.sine;
    const float m15 = half_2.cosine + half_2.sine;
    const float m16 = 2.0f * half_3.sine;
    const float m17 = m16 * half_3.sine;
    const float m18 = m17 - 1.0f;
    const float m19 = m16 * half_3.cosine;
    const float m20 = m14 * half_3.cosine;
    const float m21 = m15 * half_3.sine;
    const float m22 = m14 * half_3.sine;
    const float m23 = m15 * half_3.cosine;
    const float m24 = m20 - m21;
    const float m25 = m21 + m20;
    const float m26 = m22 + m23;
    const float m27 = m23 - m22;
    const float m28 = m13 * m19;
    const float m29 = m12 * m19;
    const float m30 = 0.171f * m18;
    const float m31 = m30 - 0.111f;
    const float m32 = m8 * m24;
    const float m33 = m9 * m27;
    const float m34 = m32 - m33;
    const float m35 = m8 * m25;
    const float m36 = m9 * m26;
    const float m37 = m35 + m36;
    const float m38 = m8 * m26;
    const float m39 = m9 * m25;
    const float m40 = m38 - m39;
    const float m41 = m8 * m27;
    const float m42 = m9 * m24;
    const float m43 = m41 + m42;
    const float m44 = m34 - m37;
    const float m45 = m37 + m34;
    const float m46 = m40 + m43;
    const float m47 = m43 - m40;
    const float m48 = m7 * m28;
    const float m49 = m6 * m31;
    const float m50 = 0.171f * m48;
    const float m51 = m49 - m50;
    const float m52 = m6 * m28;
    const float m53 = m7 * m31;
    const float m54 = 0.171f * m52;
    const float m55 = m53 + m54;
    const float m56 = half_0.cosine * m44;
    const float m57 = half_0.sine * m47;
    const float m58 = m56 - m57;
    const float m59 = half_0.cosine * m45;
    const float m60 = half_0.sine * m46;
    const float m61 = m59 + m60;
    const float m62 = half_0.cosine * m46;
    const float m63 = half_0.sine * m45;
    const float m64 = m62 - m63;
    const float m65 = half_0.cosine * m47;
    const float m66 = half_0.sine * m44;
    const float m67 = m65 + m66;
    const float m68 = m58 + m61;
    const float m69 = m61 - m58;
    const float m70 = m64 - m67;
    const float m71 = m67 + m64;
    const float m72 = m2 * m51;
    const float m73 = m3 * m29;
    const float m74 = 0.171f * m73;
    const float m75 = m72 - m74;
    const float m76 = m3 * m51;
    const float m77 = m2 * m29;
    const float m78 = 0.171f * m77;
    const float m79 = m76 + m78;
    const float m80 = m75 + 0.035f;
    const float m81 = m55 + 0.111f;
    const float m82 = m79 - 0.125f;
    return (pose_t){{0.176776695f * m68, 0.176776695f * m69, -0.176776695f * m70, 0.176776695f * m71}, {-m80, -m81, -m82}};
}

/* joint_ends_solve() for this arm. */
__attribute__((noinline)) static void solve_at_ends(joint_ends_t ends, float velocity_radps[],
                                                          float matrix_00, float matrix_10, float matrix_11, float matrix_20, float matrix_21, float matrix_22,
                                                          float matrix_30, float matrix_31, float matrix_32, float matrix_33, float pull_0, float pull_1,
                                                          float pull_2, float pull_3) {
    uint8_t out = 0;
    for (;;) {
        const float inverse_0 = 1.0f / matrix_00;
        const float factor_10 = matrix_10 * inverse_0;
        const float pivot_1 = matrix_11 - matrix_10 * factor_10;
        const float carried_1 = pull_1 - factor_10 * pull_0;
        const float inverse_1 = 1.0f / pivot_1;
        const float factor_20 = matrix_20 * inverse_0;
        const float row_21 = matrix_21 - matrix_20 * factor_10;
        const float factor_21 = row_21 * inverse_1;
        const float pivot_2 = matrix_22 - matrix_20 * factor_20 - row_21 * factor_21;
        const float carried_2 = pull_2 - factor_20 * pull_0 - factor_21 * carried_1;
        const float factor_30 = matrix_30 * inverse_0;
        const float row_31 = matrix_31 - matrix_30 * factor_10;
        const float factor_31 = row_31 * inverse_1;
        const float row_32 = matrix_32 - matrix_30 * factor_20 - row_31 * factor_21;
        const float pivot_3 = matrix_33 - matrix_30 * factor_30 - row_31 * factor_31;
        const float carried_3 = pull_3 - factor_30 * pull_0 - factor_31 * carried_1;
        const float determinant = pivot_2 * pivot_3 - row_32 * row_32;
        const float over = 1.0f / (determinant);
        const float wanted_2 = pivot_3 * carried_2 - row_32 * carried_3;
        const float speed_2 = (wanted_2) * over;
        const float wanted_3 = pivot_2 * carried_3 - row_32 * carried_2;
        const float speed_3 = (wanted_3) * over;
        const float speed_1 = carried_1 * inverse_1 - factor_21 * speed_2 - factor_31 * speed_3;
        const float speed_0 = pull_0 * inverse_0 - factor_10 * speed_1 - factor_20 * speed_2 - factor_30 * speed_3;
        velocity_radps[0] = speed_0;
        velocity_radps[1] = speed_1;
        velocity_radps[2] = speed_2;
        velocity_radps[3] = speed_3;
        const uint8_t more = joint_ends_leave_out(ends, 4, velocity_radps, &out);
        if (more == 0u) {
            return;
        }
        if ((more & 1) != 0) {
            matrix_10 = matrix_20 = matrix_30 = pull_0 = 0.0f;
        }
        if ((more & 2) != 0) {
            matrix_10 = matrix_21 = matrix_31 = pull_1 = 0.0f;
        }
        if ((more & 4) != 0) {
            matrix_20 = matrix_21 = matrix_32 = pull_2 = 0.0f;
        }
        if ((more & 8) != 0) {
            matrix_30 = matrix_31 = matrix_32 = pull_3 = 0.0f;
        }
    }
}

/* velocity_control_isotropic() for this arm. */
static void isotropic(const arm_t *arm, const velocity_control_config_t *config, const velocity_request_t *request,
                      float velocity_radps[]) {
    const velocity_isotropic_t *const law = &config->isotropic;
    const float *const position_rad = request->position_rad;
    const pose_t *const target = request->target;
    const float half_0 = 0.5f * position_rad[0];
    const float half_1 = 0.5f * position_rad[1];
    const float half_2 = 0.5f * position_rad[2];
    const float half_3 = 0.5f * position_rad[3];
    float sine_0, sine_1, sine_2, sine_3, cosine_0, cosine_1, cosine_2, cosine_3;
    if (sine_cosine_is_small(half_0) && sine_cosine_is_small(half_1) && sine_cosine_is_small(half_2) && sine_cosine_is_small(half_3)) {
        const float z_0 = half_0 * half_0;
        const float z_1 = half_1 * half_1;
        const float z_2 = half_2 * half_2;
        const float z_3 = half_3 * half_3;
        sine_0 = SINE_9 * z_0;
        sine_1 = SINE_9 * z_1;
        sine_2 = SINE_9 * z_2;
        sine_3 = SINE_9 * z_3;
        sine_0 = (sine_0 + SINE_7) * z_0;
        sine_1 = (sine_1 + SINE_7) * z_1;
        sine_2 = (sine_2 + SINE_7) * z_2;
        sine_3 = (sine_3 + SINE_7) * z_3;
        sine_0 = (sine_0 + SINE_5) * z_0;
        sine_1 = (sine_1 + SINE_5) * z_1;
        sine_2 = (sine_2 + SINE_5) * z_2;
        sine_3 = (sine_3 + SINE_5) * z_3;
        sine_0 = sine_0 + SINE_3;
        sine_1 = sine_1 + SINE_3;
        sine_2 = sine_2 + SINE_3;
        sine_3 = sine_3 + SINE_3;
        cosine_0 = COSINE_10 * z_0;
        cosine_1 = COSINE_10 * z_1;
        cosine_2 = COSINE_10 * z_2;
        cosine_3 = COSINE_10 * z_3;
        cosine_0 = (cosine_0 + COSINE_8) * z_0;
        cosine_1 = (cosine_1 + COSINE_8) * z_1;
        cosine_2 = (cosine_2 + COSINE_8) * z_2;
        cosine_3 = (cosine_3 + COSINE_8) * z_3;
        cosine_0 = (cosine_0 + COSINE_6) * z_0;
        cosine_1 = (cosine_1 + COSINE_6) * z_1;
        cosine_2 = (cosine_2 + COSINE_6) * z_2;
        cosine_3 = (cosine_3 + COSINE_6) * z_3;
        cosine_0 = cosine_0 + COSINE_4;
        cosine_1 = cosine_1 + COSINE_4;
        cosine_2 = cosine_2 + COSINE_4;
        cosine_3 = cosine_3 + COSINE_4;
        sine_0 = sine_0 * (z_0 * half_0) + half_0;
        sine_1 = sine_1 * (z_1 * half_1) + half_1;
        sine_2 = sine_2 * (z_2 * half_2) + half_2;
        sine_3 = sine_3 * (z_3 * half_3) + half_3;
        cosine_0 = cosine_0 * (z_0 * z_0) + (1.0f - 0.5f * z_0);
        cosine_1 = cosine_1 * (z_1 * z_1) + (1.0f - 0.5f * z_1);
        cosine_2 = cosine_2 * (z_2 * z_2) + (1.0f - 0.5f * z_2);
        cosine_3 = cosine_3 * (z_3 * z_3) + (1.0f - 0.5f * z_3);
    } else {
        const sine_cosine_t both_0 = sine_cosine(half_0);
        sine_0 = both_0.sine;
        cosine_0 = both_0.cosine;
        const sine_cosine_t both_1 = sine_cosine(half_1);
        sine_1 = both_1.sine;
        cosine_1 = both_1.cosine;
        const sine_cosine_t both_2 = sine_cosine(half_2);
        sine_2 = both_2.sine;
        cosine_2 = both_2.cosine;
        const sine_cosine_t both_3 = sine_cosine(half_3);
        sine_3 = both_3.sine;
        cosine_3 = both_3.cosine;
    }
    const float m0 = 2.0f * sine_0;
    const float m1 = m0 * sine_0;
    const float m2 = m1 - 1.0f;
    const float m3 = m0 * cosine_0;
    const float m4 = 2.0f * sine_1;
    const float m5 = m4 * sine_1;
    const float m6 = m5 - 1.0f;
    const float m7 = m4 * cosine_1;
    const float m8 = cosine_1 - sine_1;
    const float m9 = cosine_1 + sine_1;
    const float m10 = 2.0f * sine_2;
    const float m11 = m10 * sine_2;
    const float m12 = m11 - 1.0f;
    const float m13 = m10 * cosine_2;
    const float m14 = cosine_2 - sine_2;
    const float m15 = cosine_2 + sine_2;
    const float m16 = 2.0f * sine_3;
    const float m17 = m16 * sine_3;
    const float m18 = m17 - 1.0f;
    const float m19 = m16 * cosine_3;
    const float m20 = m13 * m19;
    const float m21 = m12 * m19;
    const float m22 = 0.171f * m18;
    const float m23 = m22 - 0.111f;
    const float m24 = target->rotation.w - target->rotation.x;
    const float m25 = target->rotation.w + target->rotation.x;
    const float m26 = target->rotation.y + target->rotation.z;
    const float m27 = target->rotation.y - target->rotation.z;
    const float m28 = m24 * cosine_3;
    const float m29 = m27 * sine_3;
    const float m30 = m28 - m29;
    const float m31 = m25 * cosine_3;
    const float m32 = m26 * sine_3;
    const float m33 = m31 - m32;
    const float m34 = m25 * sine_3;
    const float m35 = m26 * cosine_3;
    const float m36 = m34 + m35;
    const float m37 = m24 * sine_3;
    const float m38 = m27 * cosine_3;
    const float m39 = m37 + m38;
    const float m40 = m30 + m33;
    const float m41 = m30 - m33;
    const float m42 = m36 + m39;
    const float m43 = m36 - m39;
    const float m44 = m40 * m14;
    const float m45 = m43 * m15;
    const float m46 = m44 + m45;
    const float m47 = m41 * m14;
    const float m48 = m42 * m15;
    const float m49 = m47 + m48;
    const float m50 = m41 * m15;
    const float m51 = m42 * m14;
    const float m52 = m50 - m51;
    const float m53 = m40 * m15;
    const float m54 = m43 * m14;
    const float m55 = m53 - m54;
    const float m56 = m46 + m49;
    const float m57 = m49 - m46;
    const float m58 = m52 - m55;
    const float m59 = m55 + m52;
    const float m60 = cosine_0 * m56;
    const float m61 = sine_0 * m59;
    const float m62 = m60 - m61;
    const float m63 = cosine_0 * m57;
    const float m64 = sine_0 * m58;
    const float m65 = m63 + m64;
    const float m66 = cosine_0 * m58;
    const float m67 = sine_0 * m57;
    const float m68 = m66 - m67;
    const float m69 = cosine_0 * m59;
    const float m70 = sine_0 * m56;
    const float m71 = m69 + m70;
    const float m72 = m62 - m65;
    const float m73 = m65 + m62;
    const float m74 = m68 + m71;
    const float m75 = m71 - m68;
    const float m76 = m8 * m72;
    const float m77 = m9 * m75;
    const float m78 = m76 - m77;
    const float m79 = m8 * m73;
    const float m80 = m9 * m74;
    const float m81 = m79 + m80;
    const float m82 = m8 * m74;
    const float m83 = m9 * m73;
    const float m84 = m82 - m83;
    const float m85 = m8 * m75;
    const float m86 = m9 * m72;
    const float m87 = m85 + m86;
    const float m88 = m78 - m81;
    const float m89 = m81 + m78;
    const float m90 = m84 + m87;
    const float m91 = m87 - m84;
    const float m92 = target->translation_m.x + 0.035f;
    const float m93 = target->translation_m.y + 0.111f;
    const float m94 = target->translation_m.z - 0.125f;
    const float m95 = m2 * m92;
    const float m96 = m3 * m94;
    const float m97 = m95 + m96;
    const float m98 = m3 * m92;
    const float m99 = m2 * m94;
    const float m100 = m98 - m99;
    const float m101 = m7 * m97;
    const float m102 = m6 * m93;
    const float m103 = m101 - m102;
    const float m104 = m6 * m97;
    const float m105 = m7 * m93;
    const float m106 = m104 + m105;
    const float m107 = m106 - 0.111f;
    const float turn_w = m88;
    const float turn_x = -m89;
    const float turn_y = -m90;
    const float turn_z = -m91;
    /* target and -target are the same pose: the nearer one */
    const float side = turn_w < 0.0f ? -0.0883883476f : 0.0883883476f;
    const float pull_rotation = side * law->pull_rotation;
    float offset_x, offset_y, offset_z, pull_turn_x, pull_turn_y, pull_turn_z, pull_dual_x, pull_dual_y, pull_dual_z;
    if (config->error_frame == ERROR_FRAME_TARGET) {
        const float a0 = 0.171f * m20;
        const float a1 = m103 - a0;
        const float a2 = 0.5f * a1;
        const float a3 = 0.171f * m21;
        const float a4 = m100 - a3;
        const float a5 = 0.5f * a4;
        const float a6 = 0.171f * m18;
        const float a7 = m107 + a6;
        const float a8 = 0.5f * a7;
        const float a9 = pull_rotation * turn_x;
        const float a10 = pull_rotation * turn_y;
        const float a11 = pull_rotation * turn_z;
        const float a12 = law->pull_translation * a2;
        const float a13 = law->pull_translation * a5;
        const float a14 = law->pull_translation * a8;
        offset_x = a2;
        offset_y = a5;
        offset_z = a8;
        pull_turn_x = a9;
        pull_turn_y = a10;
        pull_turn_z = a11;
        pull_dual_x = a12;
        pull_dual_y = a13;
        pull_dual_z = a14;
    } else {
        const float b0 = 3.57142857f * m3;
        const float b1 = m2 - b0;
        const float b2 = 3.57142857f * m2;
        const float b3 = m3 + b2;
        const float b4 = m7 * b1;
        const float b5 = 3.17142857f * m6;
        const float b6 = b4 - b5;
        const float b7 = m6 * b1;
        const float b8 = 3.17142857f * m7;
        const float b9 = b7 + b8;
        const float b10 = 0.035f * b9;
        const float b11 = b10 - 0.111f;
        const float b12 = 0.035f * b6;
        const float b13 = m103 - b12;
        const float b14 = 0.5f * b13;
        const float b15 = 0.035f * b3;
        const float b16 = m100 - b15;
        const float b17 = 0.5f * b16;
        const float b18 = m107 - b11;
        const float b19 = 0.5f * b18;
        const float b20 = 0.204678363f * b6;
        const float b21 = m20 - b20;
        const float b22 = 0.0855f * b21;
        const float b23 = 0.204678363f * b3;
        const float b24 = m21 - b23;
        const float b25 = 0.0855f * b24;
        const float b26 = 0.171f * m18;
        const float b27 = b11 + b26;
        const float b28 = 0.5f * b27;
        const float b29 = turn_w * b14;
        const float b30 = turn_w * b17;
        const float b31 = turn_w * b19;
        const float b32 = b17 * turn_z;
        const float b33 = b19 * turn_y;
        const float b34 = b32 - b33;
        const float b35 = b19 * turn_x;
        const float b36 = b14 * turn_z;
        const float b37 = b35 - b36;
        const float b38 = b14 * turn_y;
        const float b39 = b17 * turn_x;
        const float b40 = b38 - b39;
        const float b41 = b29 + b34;
        const float b42 = b30 + b37;
        const float b43 = b31 + b40;
        const float b44 = side * b41;
        const float b45 = side * b42;
        const float b46 = side * b43;
        const float b47 = b44 - b22;
        const float b48 = b45 - b25;
        const float b49 = b46 + b28;
        const float b50 = b14 * turn_x;
        const float b51 = b17 * turn_y;
        const float b52 = b19 * turn_z;
        const float b53 = b50 + b51;
        const float b54 = b53 + b52;
        const float b55 = side * b54;
        const float b56 = law->pull_translation * b55;
        const float b57 = pull_rotation * turn_x;
        const float b58 = pull_rotation * turn_y;
        const float b59 = pull_rotation * turn_z;
        const float b60 = b56 * b22;
        const float b61 = b56 * b25;
        const float b62 = b56 * b28;
        const float b63 = b57 + b60;
        const float b64 = b58 + b61;
        const float b65 = b59 - b62;
        const float b66 = law->pull_translation * b47;
        const float b67 = law->pull_translation * b48;
        const float b68 = law->pull_translation * b49;
        offset_x = -b22;
        offset_y = -b25;
        offset_z = b28;
        pull_turn_x = b63;
        pull_turn_y = b64;
        pull_turn_z = b65;
        pull_dual_x = b66;
        pull_dual_y = b67;
        pull_dual_z = b68;
    }
    const float n0 = 0.171f * m20;
    const float n1 = offset_x + n0;
    const float n2 = 0.171f * m21;
    const float n3 = offset_y + n2;
    const float n4 = m23 - offset_z;
    const float n5 = m6 * offset_x;
    const float n6 = m7 * offset_z;
    const float n7 = n5 - n6;
    const float n8 = m7 * n3;
    const float n9 = m7 * n1;
    const float n10 = m6 * n4;
    const float n11 = n9 - n10;
    const float n12 = m6 * n3;
    const float n13 = m6 * pull_turn_x;
    const float n14 = m7 * pull_turn_z;
    const float n15 = n8 * pull_dual_x;
    const float n16 = n11 * pull_dual_y;
    const float n17 = n12 * pull_dual_z;
    const float n18 = n13 - n14;
    const float n19 = n18 + n15;
    const float n20 = n19 - n16;
    const float n21 = n20 + n17;
    const float n22 = n7 * n7;
    const float n23 = n8 * n8;
    const float n24 = n11 * n11;
    const float n25 = n12 * n12;
    const float n26 = n22 + n23;
    const float n27 = n26 + n24;
    const float n28 = n27 + n25;
    const float n29 = law->diagonal + n28;
    const float n30 = n4 * pull_dual_x;
    const float n31 = n1 * pull_dual_z;
    const float n32 = pull_turn_y - n30;
    const float n33 = n32 - n31;
    const float n34 = offset_y * n7;
    const float n35 = n4 * n8;
    const float n36 = n1 * n12;
    const float n37 = n34 - n35;
    const float n38 = n37 - n36;
    const float n39 = offset_y * offset_y;
    const float n40 = n4 * n4;
    const float n41 = n1 * n1;
    const float n42 = n39 + n40;
    const float n43 = n42 + n41;
    const float n44 = law->diagonal + n43;
    const float n45 = 0.171f * m18;
    const float n46 = offset_z - n45;
    const float n47 = n3 * pull_dual_x;
    const float n48 = n1 * pull_dual_y;
    const float n49 = pull_turn_z - n47;
    const float n50 = n49 + n48;
    const float n51 = law->weight_rotation * m7;
    const float n52 = offset_z * n7;
    const float n53 = n3 * n8;
    const float n54 = n1 * n11;
    const float n55 = n52 - n53;
    const float n56 = n55 - n54;
    const float n57 = n51 - n56;
    const float n58 = offset_z * offset_y;
    const float n59 = n3 * n4;
    const float n60 = n58 + n59;
    const float n61 = offset_z * offset_z;
    const float n62 = n3 * n3;
    const float n63 = n61 + n62;
    const float n64 = n63 + n41;
    const float n65 = law->diagonal + n64;
    const float n66 = m12 * offset_x;
    const float n67 = m13 * offset_y;
    const float n68 = n66 - n67;
    const float n69 = m13 * n46;
    const float n70 = m12 * n46;
    const float n71 = m12 * n3;
    const float n72 = m13 * n1;
    const float n73 = n71 + n72;
    const float n74 = m12 * pull_turn_x;
    const float n75 = m13 * pull_turn_y;
    const float n76 = n69 * pull_dual_x;
    const float n77 = n70 * pull_dual_y;
    const float n78 = n73 * pull_dual_z;
    const float n79 = n74 - n75;
    const float n80 = n79 - n76;
    const float n81 = n80 - n77;
    const float n82 = n81 + n78;
    const float n83 = m12 * m6;
    const float n84 = law->weight_rotation * n83;
    const float n85 = n68 * n7;
    const float n86 = n69 * n8;
    const float n87 = n70 * n11;
    const float n88 = n73 * n12;
    const float n89 = n85 - n86;
    const float n90 = n89 + n87;
    const float n91 = n90 + n88;
    const float n92 = n84 + n91;
    const float n93 = law->weight_rotation * m13;
    const float n94 = n68 * offset_y;
    const float n95 = n69 * n4;
    const float n96 = n73 * n1;
    const float n97 = n94 + n95;
    const float n98 = n97 - n96;
    const float n99 = n93 - n98;
    const float n100 = n68 * offset_z;
    const float n101 = n69 * n3;
    const float n102 = n70 * n1;
    const float n103 = n100 + n101;
    const float n104 = n103 - n102;
    const float n105 = n68 * n68;
    const float n106 = n69 * n69;
    const float n107 = n70 * n70;
    const float n108 = n73 * n73;
    const float n109 = n105 + n106;
    const float n110 = n109 + n107;
    const float n111 = n110 + n108;
    const float n112 = law->diagonal + n111;
    const float n113 = n28 + n43;
    const float n114 = n113 + n64;
    const float n115 = n114 + n111;
    if (!(n115 <= law->trace_max)) {
        velocity_control_general(arm, config, request, velocity_radps);
        return;
    }
    const float matrix_00 = n29;
    const float matrix_10 = -n38;
    const float matrix_11 = n44;
    const float matrix_20 = n57;
    const float matrix_21 = n60;
    const float matrix_22 = n65;
    const float matrix_30 = n92;
    const float matrix_31 = n99;
    const float matrix_32 = -n104;
    const float matrix_33 = n112;
    const float pull_0 = -n21;
    const float pull_1 = n33;
    const float pull_2 = n50;
    const float pull_3 = -n82;
    if ((request->ends.lower | request->ends.upper) != 0) {
        solve_at_ends(request->ends, velocity_radps,
                      matrix_00, matrix_10, matrix_11, matrix_20, matrix_21, matrix_22,
                      matrix_30, matrix_31, matrix_32, matrix_33, pull_0, pull_1,
                      pull_2, pull_3);
        return;
    }
    const float inverse_0 = 1.0f / matrix_00;
    const float factor_10 = matrix_10 * inverse_0;
    const float pivot_1 = matrix_11 - matrix_10 * factor_10;
    const float carried_1 = pull_1 - factor_10 * pull_0;
    const float inverse_1 = 1.0f / pivot_1;
    const float factor_20 = matrix_20 * inverse_0;
    const float row_21 = matrix_21 - matrix_20 * factor_10;
    const float factor_21 = row_21 * inverse_1;
    const float pivot_2 = matrix_22 - matrix_20 * factor_20 - row_21 * factor_21;
    const float carried_2 = pull_2 - factor_20 * pull_0 - factor_21 * carried_1;
    const float factor_30 = matrix_30 * inverse_0;
    const float row_31 = matrix_31 - matrix_30 * factor_10;
    const float factor_31 = row_31 * inverse_1;
    const float row_32 = matrix_32 - matrix_30 * factor_20 - row_31 * factor_21;
    const float pivot_3 = matrix_33 - matrix_30 * factor_30 - row_31 * factor_31;
    const float carried_3 = pull_3 - factor_30 * pull_0 - factor_31 * carried_1;
    const float determinant = pivot_2 * pivot_3 - row_32 * row_32;
    const float over = 1.0f / (determinant);
    const float wanted_2 = pivot_3 * carried_2 - row_32 * carried_3;
    const float speed_2 = (wanted_2) * over;
    const float wanted_3 = pivot_2 * carried_3 - row_32 * carried_2;
    const float speed_3 = (wanted_3) * over;
    const float speed_1 = carried_1 * inverse_1 - factor_21 * speed_2 - factor_31 * speed_3;
    const float speed_0 = pull_0 * inverse_0 - factor_10 * speed_1 - factor_20 * speed_2 - factor_30 * speed_3;
    velocity_radps[0] = speed_0;
    velocity_radps[1] = speed_1;
    velocity_radps[2] = speed_2;
    velocity_radps[3] = speed_3;
}

const arm_t arm_hoap3_right = {
    .name = "hoap3_right",
    .id = 0,
    .joint_count = 4,
    .joints = joints,
    .effector = {{0.707106781f, -0.707106781f, 0.0f, 0.0f}, {0.0f, 0.171f, 0.0f}},
    .forward_kinematics = forward_kinematics,
    .isotropic = isotropic,
};
