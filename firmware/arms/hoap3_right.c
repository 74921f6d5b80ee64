/* Made by `make arms` from hoap3_right.toml: edit that. */
/* clang-format off */
#include "hoap3_right.h"

#include "../maths/trigonometry.h"

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

const arm_t arm_hoap3_right = {
    .name = "hoap3_right",
    .id = 0,
    .joint_count = 4,
    .joints = joints,
    .effector = {{0.707106781f, -0.707106781f, 0.0f, 0.0f}, {0.0f, 0.171f, 0.0f}},
    .forward_kinematics = forward_kinematics,
};
