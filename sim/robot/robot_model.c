#include "robot_model.h"

#include <math.h>
#include <stddef.h>

#define RIGHT_ANGLE (ROBOT_PI / 2.0)
#define DEG(x) ((x) * ROBOT_RAD_PER_DEG)

/* Fixed transforms from the waist to the frame of the first joint: WAIST -> CHEST -> RARM[0]. */
#define CHEST_A_M (-0.035)
#define CHEST_D_M 0.125
#define SHOULDER_ALPHA_RAD (-RIGHT_ANGLE)
#define SHOULDER_D_M (-0.111)

/* The links' bodies are a 50 mm cube and three rods of 40 mm diameter. The cube is the shoulder's servo. The rods are
 * the two halves of the upper arm, above and below its torsion joint, and the forearm with the hand. */
const robot_joint_t robot_joint_table[ROBOT_JOINTS] = {
    {.alpha_rad = 0.0,
     .offset_rad = 0.0,
     .stop_min_rad = DEG(-91.0),
     .stop_max_rad = DEG(151.0),
     .mass_kg = 0.210,
     .shape = LINK_BOX,
     .length_m = 0.050},
    {.alpha_rad = RIGHT_ANGLE,
     .offset_rad = RIGHT_ANGLE,
     .stop_min_rad = DEG(-96.0),
     .stop_max_rad = DEG(1.0),
     .mass_kg = 0.234,
     .shape = LINK_ROD_Y,
     .length_m = ROBOT_UPPER_ARM_M / 2.0,
     .radius_m = 0.020,
     .centre_m = {0.0, -ROBOT_UPPER_ARM_M / 4.0, 0.0}},
    {.alpha_rad = RIGHT_ANGLE,
     .d_m = ROBOT_UPPER_ARM_M,
     .offset_rad = RIGHT_ANGLE,
     .stop_min_rad = DEG(-91.0),
     .stop_max_rad = DEG(91.0),
     .mass_kg = 0.1965,
     .shape = LINK_ROD_Z,
     .length_m = ROBOT_UPPER_ARM_M / 2.0,
     .radius_m = 0.020,
     .centre_m = {0.0, 0.0, -ROBOT_UPPER_ARM_M / 4.0}},
    {.alpha_rad = RIGHT_ANGLE,
     .offset_rad = 0.0,
     .stop_min_rad = DEG(-115.0),
     .stop_max_rad = DEG(1.0),
     .mass_kg = 0.216,
     .shape = LINK_ROD_Y,
     .length_m = ROBOT_FOREARM_M,
     .radius_m = 0.020,
     .centre_m = {0.0, ROBOT_FOREARM_M / 2.0, 0.0}},
};

/* Rot_x(-90 deg), which makes the hand's z axis parallel to the last link's y axis. */
const double robot_hand_rotation[4] = {0.70710678118654752440, -0.70710678118654752440, 0.0, 0.0};
const double robot_hand_offset_m[3] = {0.0, ROBOT_FOREARM_M, 0.0};
static const double hand_rotation_matrix[9] = {1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0};

/* Computes c = a b, where b is the transform with this rotation and position. */
static void transform_multiply(const transform_t *a, const double rotation[9], const double position_m[3],
                               transform_t *c) {
    for (size_t row = 0; row < 3; row++) {
        const double *r = &a->rotation[3 * row];
        for (size_t column = 0; column < 3; column++) {
            c->rotation[3 * row + column] =
                r[0] * rotation[column] + r[1] * rotation[3 + column] + r[2] * rotation[6 + column];
        }
        c->position_m[row] = a->position_m[row] + r[0] * position_m[0] + r[1] * position_m[1] + r[2] * position_m[2];
    }
}

/* Appends the modified DH transform Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d) to `from`. */
static void append_modified_dh(const transform_t *from, double alpha_rad, double a_m, double d_m, double theta_rad,
                               transform_t *to) {
    const double ca = cos(alpha_rad), sa = sin(alpha_rad), ct = cos(theta_rad), st = sin(theta_rad);
    const double rotation[9] = {ct, -st, 0.0, st * ca, ct * ca, -sa, st * sa, ct * sa, ca};
    const double position_m[3] = {a_m, -sa * d_m, ca * d_m};
    transform_multiply(from, rotation, position_m, to);
}

void robot_model_forward(const double position_rad[ROBOT_JOINTS], transform_t link[ROBOT_JOINTS], transform_t *hand) {
    const transform_t waist = {.rotation = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}};
    transform_t chest, frame, next;
    append_modified_dh(&waist, 0.0, CHEST_A_M, CHEST_D_M, 0.0, &chest);
    append_modified_dh(&chest, SHOULDER_ALPHA_RAD, 0.0, SHOULDER_D_M, 0.0, &frame);
    for (size_t i = 0; i < ROBOT_JOINTS; i++) {
        const robot_joint_t *joint = &robot_joint_table[i];
        append_modified_dh(&frame, joint->alpha_rad, joint->a_m, joint->d_m, position_rad[i] + joint->offset_rad,
                           &next);
        frame = next;
        if (link != NULL) {
            link[i] = frame;
        }
    }
    transform_multiply(&frame, hand_rotation_matrix, robot_hand_offset_m, hand);
}

double robot_model_position_min_rad(int joint) {
    return robot_joint_table[joint].stop_min_rad + ROBOT_STOP_MARGIN_RAD;
}

double robot_model_position_max_rad(int joint) {
    return robot_joint_table[joint].stop_max_rad - ROBOT_STOP_MARGIN_RAD;
}
