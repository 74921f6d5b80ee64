/* The right arm of the Fujitsu HOAP-3, as specified in its instruction manual (tables 6.1-2 and 6.4-1): modified DH
 * parameters (Craig), masses, stops, torques and encoders. The plant and the monitors share this model, which is in
 * double precision. The firmware uses a separate table in a different convention, so that the two can be checked
 * against each other. Torso frame: x forward, y left, z up. */
#ifndef COMANIP_SIM_ROBOT_MODEL_H
#define COMANIP_SIM_ROBOT_MODEL_H

#define ROBOT_JOINTS 4

#define ROBOT_PI 3.14159265358979323846
#define ROBOT_RAD_PER_DEG (ROBOT_PI / 180.0)

#define ROBOT_STOP_MARGIN_RAD (1.0 * ROBOT_RAD_PER_DEG) /* from a mechanical stop to the joint limit */
#define ROBOT_VELOCITY_MAX_RADPS 4.76                   /* 272.7 deg/s */
#define ROBOT_JERK_MAX_RADPS3 10000.0                   /* limit of the commands to the drives; not from the manual */
#define ROBOT_TORQUE_PEAK_NM 3.0
#define ROBOT_PULSES_PER_DEGREE 209.0

#define ROBOT_UPPER_ARM_M 0.111
#define ROBOT_FOREARM_M 0.171

typedef enum {
    LINK_BOX,   /* a cube with edges of `length_m` */
    LINK_ROD_Y, /* a cylinder along the link frame's y axis */
    LINK_ROD_Z, /* a cylinder along the link frame's z axis */
} link_shape_t;

/* A joint and the link that it moves. The link frame is the modified DH frame of the joint. */
typedef struct {
    double alpha_rad, a_m, d_m, offset_rad; /* DH parameters; joint angle = theta - offset */
    double stop_min_rad, stop_max_rad;      /* mechanical stops */
    double mass_kg;
    link_shape_t shape; /* assumed homogeneous body, because the manual does not give the inertia */
    double length_m, radius_m;
    double centre_m[3]; /* centre of mass in the link frame */
} robot_joint_t;

extern const robot_joint_t robot_joint_table[ROBOT_JOINTS];

/* Pose of a frame in the torso frame. rotation: row-major. */
typedef struct {
    double rotation[9];
    double position_m[3];
} transform_t;

/* Computes the poses of the link frames and of the end effector (z along the forearm; x up when the forearm points
 * forward). link may be NULL. */
void robot_model_forward(const double position_rad[ROBOT_JOINTS], transform_t link[ROBOT_JOINTS], transform_t *hand);

/* Pose of the end effector in the frame of the last link: quaternion (w, x, y, z) and offset. */
extern const double robot_hand_rotation[4];
extern const double robot_hand_offset_m[3];

double robot_model_position_min_rad(int joint);
double robot_model_position_max_rad(int joint);

#endif
