/* Sizes and shapes of the robot's parts and of the people. */
#include "bodies.h"

#include <math.h>
#include <string.h>

#define ARM_RADIUS_M 0.020 /* the arm's links are rods of 40 mm diameter, as in robot_model.c */
#define SHOULDER_M 0.050
#define WRIST_RADIUS_M 0.030
#define ELBOW_RADIUS_M 0.045
#define RING_POINTS (BODIES_FOREARM_POINTS / 2)

/* Assumed sizes for a robot of 0.6 m height, because the manual does not include outlines. The centres of torso and
 * head are relative to the waist frame, whose origin is at the hip. */
static const double gripper_size_m[3] = {0.040, 0.050, 0.050};
static const double torso_size_m[3] = {0.100, 0.150, 0.190};
static const double torso_centre_m[3] = {-0.035, 0.0, 0.085};
static const double head_size_m[3] = {0.110, 0.120, 0.120};
static const double head_centre_m[3] = {-0.030, 0.0, 0.260};

/* Points around the wrist, the knuckles and the fingertips of an adult's flat hand, in the hand's frame (z forward, x
 * up). The hand measures 0.18 x 0.085 x 0.03 m. */
static const double flat_hand_m[][3] = {
    {-0.015, -0.030, -BODIES_WRIST_M},
    {-0.015, 0.030, -BODIES_WRIST_M},
    {0.015, -0.030, -BODIES_WRIST_M},
    {0.015, 0.030, -BODIES_WRIST_M},
    {-0.015, -0.0425, 0.030},
    {-0.015, 0.0425, 0.030},
    {0.015, -0.0425, 0.030},
    {0.015, 0.0425, 0.030},
    {-0.008, -0.030, 0.120},
    {-0.008, 0.030, 0.120},
    {0.008, -0.030, 0.120},
    {0.008, 0.030, 0.120},
};

/* Points of the same hand with its fingers around an object. */
static const double grasping_hand_m[][3] = {
    {-0.015, -0.030, -BODIES_WRIST_M}, {-0.015, 0.030, -BODIES_WRIST_M}, {0.015, -0.030, -BODIES_WRIST_M},
    {0.015, 0.030, -BODIES_WRIST_M},   {-0.030, -0.0425, -0.020},        {-0.030, 0.0425, -0.020},
    {0.030, -0.0425, -0.020},          {0.030, 0.0425, -0.020},          {-0.030, -0.0425, 0.045},
    {-0.030, 0.0425, 0.045},           {0.030, -0.0425, 0.045},          {0.030, 0.0425, 0.045},
};

#define HAND_POINTS ((int)(sizeof flat_hand_m / sizeof flat_hand_m[0]))
_Static_assert(sizeof flat_hand_m == sizeof grasping_hand_m, "both hands have the same number of points");

static void set_shape(body_t *body, convex_shape_t shape) {
    body->shape = shape;
    body->shape.pose.rotation[0] = 1.0;
    convex_shape_finish(&body->shape);
    body->present = true;
}

static void set_box(body_t *body, const double size_m[3]) {
    set_shape(body, (convex_shape_t){.kind = SHAPE_BOX, .size_m = {size_m[0], size_m[1], size_m[2]}});
}

static void set_cylinder(body_t *body, double length_m, double radius_m) {
    set_shape(body, (convex_shape_t){.kind = SHAPE_CYLINDER, .length_m = length_m, .radius_m = radius_m});
}

/* Uses the cup's outer surface with a flat lid, because the shape must be convex. */
static void set_cup(body_t *body, const cup_t *cup) {
    if (cup->present) {
        set_cylinder(body, cup->height_m + cup->wall_m, cup->radius_m + cup->wall_m);
    }
}

void body_set_rod(body_t *self, const object_t *rod) {
    set_cylinder(self, rod->length_m, rod->radius_m);
}

static void init_robot(body_t robot[BODIES_ROBOT_PARTS], const scenario_t *scenario) {
    const double shoulder_m[3] = {SHOULDER_M, SHOULDER_M, SHOULDER_M};
    set_cylinder(&robot[ROBOT_PART_FOREARM], ROBOT_FOREARM_M, ARM_RADIUS_M);
    set_cylinder(&robot[ROBOT_PART_UPPER_ARM], ROBOT_UPPER_ARM_M, ARM_RADIUS_M);
    set_box(&robot[ROBOT_PART_GRIPPER], gripper_size_m);
    set_box(&robot[ROBOT_PART_SHOULDER], shoulder_m);
    set_box(&robot[ROBOT_PART_TORSO], torso_size_m);
    set_box(&robot[ROBOT_PART_HEAD], head_size_m);
    memcpy(robot[ROBOT_PART_TORSO].shape.pose.position_m, torso_centre_m, sizeof torso_centre_m);
    memcpy(robot[ROBOT_PART_HEAD].shape.pose.position_m, head_centre_m, sizeof head_centre_m);
    set_cup(&robot[ROBOT_PART_CUP], &scenario->cup);
}

rigid_pose_t body_wrist(const rigid_pose_t *hand) {
    const rigid_pose_t wrist = {.position_m = {0.0, 0.0, -BODIES_WRIST_M}, .rotation = {1.0, 0.0, 0.0, 0.0}};
    return rigid_pose_multiply(hand, &wrist);
}

double body_distance_m(const double a[3], const double b[3]) {
    return sqrt((b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]) + (b[2] - a[2]) * (b[2] - a[2]));
}

static bool grips_objects(const person_t *person) {
    bool takes = person->cup.present;
    for (size_t i = 0; i < person->step_count; i++) {
        takes = takes || person->step[i].action == PERSON_GRIP;
    }
    for (size_t i = 0; i < person->recorded_step_count; i++) {
        takes = takes || person->recorded_step[i].action == PERSON_GRIP;
    }
    return takes;
}

/* The forearm lies along z from wrist to elbow, with the origin at its centre. */
static void init_forearm(bodies_t *self, size_t person, const person_t *who) {
    const rigid_pose_t wrist = body_wrist(&who->start);
    const double length_m = body_distance_m(wrist.position_m, who->elbow_m);
    double (*point)[3] = self->forearm_point[person];
    for (int i = 0; i < RING_POINTS; i++) {
        const double angle_rad = 2.0 * ROBOT_PI * i / RING_POINTS;
        const double c = cos(angle_rad), s = sin(angle_rad);
        memcpy(point[i], (double[3]){WRIST_RADIUS_M * c, WRIST_RADIUS_M * s, -0.5 * length_m}, sizeof point[i]);
        memcpy(point[i + RING_POINTS], (double[3]){ELBOW_RADIUS_M * c, ELBOW_RADIUS_M * s, 0.5 * length_m},
               sizeof point[i]);
    }
    self->forearm_m[person] = length_m;
    set_shape(&self->person[person][PERSON_PART_FOREARM], (convex_shape_t){.kind = SHAPE_HULL,
                                                                           .points = (const double (*)[3])point,
                                                                           .point_count = BODIES_FOREARM_POINTS});
}

static void init_person(bodies_t *self, size_t person, const person_t *who) {
    set_shape(&self->person[person][PERSON_PART_HAND],
              (convex_shape_t){.kind = SHAPE_HULL,
                               .points = grips_objects(who) ? grasping_hand_m : flat_hand_m,
                               .point_count = HAND_POINTS});
    set_cup(&self->person[person][PERSON_PART_CUP], &who->cup);
    init_forearm(self, person, who);
}

void bodies_init(bodies_t *self, const scenario_t *scenario) {
    memset(self, 0, sizeof *self);
    init_robot(self->robot, scenario);
    for (size_t i = 0; i < scenario->person_count; i++) {
        init_person(self, i, &scenario->person[i]);
    }
    self->robot[ROBOT_PART_HELD].object = BODY_NO_OBJECT;
    for (size_t i = 0; i < SCENARIO_MAX_PEOPLE; i++) {
        self->person[i][PERSON_PART_HELD].object = BODY_NO_OBJECT;
    }
}
