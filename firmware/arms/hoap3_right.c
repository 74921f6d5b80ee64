#include "hoap3_right.h"

/* Fujitsu HOAP-3 Instruction Manual, tables 6.1-2 (lengths, modified DH) and 6.4-1 (joint ranges). From the DH chain
 *
 *   joint          alpha_{i-1}  d        theta
 *   (torso->chest)   0          0.125    0 (a = -0.035)
 *   (chest->arm)   -90 deg     -0.111    0
 *   1 pitch          0          0        th1
 *   2 roll          90 deg      0        th2 + 90 deg
 *   3 torsion       90 deg      0.111    th3 + 90 deg
 *   4 elbow         90 deg      0        th4, hand at 0.171 along y4
 *
 * each `fixed` is Rot_x(alpha) Trans_z(d) Rot_z(offset): the offset turns before the joint does, about the same axis z.
 * The hand frame has z forward along the forearm, x up: x_hand = x4, z_hand = y4. */

#define DEGREE 0.017453292519943295f
#define SIN_45 0.70710678118654752f
#define UPPER_ARM_M 0.111f
#define FOREARM_M 0.171f
#define VELOCITY_MAX_RADPS 4.76f /* 272.7 deg/s */

/* One degree inside the mechanical stops, as the manual asks. */
#define RANGE(min_deg, max_deg) (((min_deg) + 1.0f) * DEGREE), (((max_deg)-1.0f) * DEGREE)

static const arm_joint_t joints[4] = {
    /* Trans(-0.035, -0.111, 0.125) Rot_x(-90 deg) */
    {{{SIN_45, -SIN_45, 0.0f, 0.0f},
      {-0.5f * 0.035f * SIN_45, -0.5f * 0.035f * SIN_45, 0.5f * (-0.111f - 0.125f) * SIN_45,
       0.5f * (0.125f - 0.111f) * SIN_45}},
     {0.0f, 0.0f, 1.0f},
     RANGE(-91.0f, 151.0f),
     VELOCITY_MAX_RADPS},
    /* Rot_x(90 deg) Rot_z(90 deg) */
    {{{0.5f, 0.5f, -0.5f, 0.5f}, {0.0f, 0.0f, 0.0f, 0.0f}}, {0.0f, 0.0f, 1.0f}, RANGE(-96.0f, 1.0f), VELOCITY_MAX_RADPS},
    /* Rot_x(90 deg) Trans_z(0.111) Rot_z(90 deg) */
    {{{0.5f, 0.5f, -0.5f, 0.5f},
      {-0.25f * UPPER_ARM_M, -0.25f * UPPER_ARM_M, -0.25f * UPPER_ARM_M, 0.25f * UPPER_ARM_M}},
     {0.0f, 0.0f, 1.0f},
     RANGE(-91.0f, 91.0f),
     VELOCITY_MAX_RADPS},
    /* Rot_x(90 deg) */
    {{{SIN_45, SIN_45, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f, 0.0f}}, {0.0f, 0.0f, 1.0f}, RANGE(-115.0f, 1.0f), VELOCITY_MAX_RADPS},
};

const arm_t arm_hoap3_right = {
    .name = "hoap3_right",
    .id = 0,
    .joint_count = 4,
    .joints = joints,
    .effector = {{SIN_45, -SIN_45, 0.0f, 0.0f}, {0.0f, 0.0f, 0.5f * FOREARM_M * SIN_45, 0.5f * FOREARM_M * SIN_45}},
};
