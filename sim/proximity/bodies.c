#include "bodies.h"

#include <math.h>
#include <string.h>

/* Added to travelled_m when a hand or the gripper holds another rod than before. It is larger than any clearance that
 * is measured, so that the next search computes all distances of the new rod. */
#define ROD_CHANGE_M 10.0

/* Moves a body to a pose, and increases travelled_m by an upper bound of the distance that any point of the body moves.
 * A point at the bounding radius R moves by at most the displacement of the origin plus the chord of the rotation,
 * 2 R sin(angle/2). For unit quaternions |p - q| = 2 sin(angle/4) >= sin(angle/2). */
static void place(body_t *body, const rigid_pose_t *pose) {
    const rigid_pose_t *last = &body->shape.pose;
    const double sign = rotation_dot(last->rotation, pose->rotation) < 0.0 ? -1.0 : 1.0;
    double turn = 0.0;
    for (int i = 0; i < 4; i++) {
        const double d = pose->rotation[i] - sign * last->rotation[i];
        turn += d * d;
    }
    body->travelled_m +=
        body_distance_m(last->position_m, pose->position_m) + 2.0 * body->shape.bounding_radius_m * sqrt(turn);
    body->shape.pose = *pose;
}

static void place_at(body_t *body, const rigid_pose_t *carrier, const double offset_m[3]) {
    rigid_pose_t mount = {.rotation = {1.0, 0.0, 0.0, 0.0}};
    memcpy(mount.position_m, offset_m, sizeof mount.position_m);
    const rigid_pose_t pose = rigid_pose_multiply(carrier, &mount);
    place(body, &pose);
}

/* Places a cup. pose: pose of the cup's frame, whose origin is the centre of the inner bottom. */
static void place_cup(body_t *body, const cup_t *cup, const rigid_pose_t *pose) {
    place_at(body, pose, (const double[3]){0.0, 0.0, 0.5 * (cup->height_m - cup->wall_m)});
}

static void place_held(body_t *body, const scenario_t *scenario, const scene_t *scene, size_t holder) {
    int held = BODY_NO_OBJECT;
    for (size_t i = 0; i < scenario->object_count; i++) {
        if (scenario->object[i].kind == OBJECT_ROD && scene_holds(scene, holder, i)) {
            held = (int)i;
        }
    }
    body->present = held != BODY_NO_OBJECT;
    if (body->present) {
        if (held != body->object) {
            body_set_rod(body, &scenario->object[held]);
            body->travelled_m += ROD_CHANGE_M;
        }
        rigid_pose_t pose;
        scene_object(scene, (size_t)held, &pose);
        place(body, &pose);
    }
    body->object = held;
}

static rigid_pose_t pose_of(const transform_t *transform) {
    rigid_pose_t pose;
    double matrix[3][3];
    memcpy(matrix, transform->rotation, sizeof matrix);
    rotation_from_matrix((const double (*)[3])matrix, pose.rotation);
    memcpy(pose.position_m, transform->position_m, sizeof pose.position_m);
    return pose;
}

static void place_robot(body_t robot[BODIES_ROBOT_PARTS], const scenario_t *scenario, const scene_t *scene) {
    const arm_plant_t *arm = scene_arm(scene);
    double position_rad[ROBOT_JOINTS];
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        position_rad[i] = arm_plant_position_rad(arm, i);
    }
    transform_t link[ROBOT_JOINTS], hand_transform;
    robot_model_forward(position_rad, link, &hand_transform);
    const rigid_pose_t shoulder = pose_of(&link[0]), elbow = pose_of(&link[2]), hand = pose_of(&hand_transform);
    place(&robot[ROBOT_PART_SHOULDER], &shoulder);
    place_at(&robot[ROBOT_PART_UPPER_ARM], &elbow, (const double[3]){0.0, 0.0, -0.5 * ROBOT_UPPER_ARM_M});
    place_at(&robot[ROBOT_PART_FOREARM], &hand, (const double[3]){0.0, 0.0, -0.5 * ROBOT_FOREARM_M});
    place_at(&robot[ROBOT_PART_GRIPPER], &hand, scenario->gripper.offset_m);
    if (scenario->cup.present) {
        rigid_pose_t cup;
        scene_robot_cup(scene, &cup);
        place_cup(&robot[ROBOT_PART_CUP], &scenario->cup, &cup);
    }
    place_held(&robot[ROBOT_PART_HELD], scenario, scene, SCENE_HOLDER_ROBOT);
}

/* Places a person's forearm so that it points from the wrist to the fixed elbow. */
static void place_forearm(bodies_t *self, size_t person, const rigid_pose_t *hand, const double elbow_m[3]) {
    body_t *forearm = &self->person[person][PERSON_PART_FOREARM];
    const rigid_pose_t wrist = body_wrist(hand);
    const double length_m = body_distance_m(wrist.position_m, elbow_m);
    rigid_pose_t pose = forearm->shape.pose;
    double along[3];
    for (int i = 0; i < 3; i++) {
        along[i] = length_m > 0.0 ? (elbow_m[i] - wrist.position_m[i]) / length_m : 0.0;
        pose.position_m[i] = wrist.position_m[i] + 0.5 * self->forearm_m[person] * along[i];
    }
    if (1.0 + along[2] > 1e-6 && length_m > 0.0) { /* smallest rotation of z onto `along`, if defined */
        const double turn[4] = {1.0 + along[2], -along[1], along[0], 0.0};
        memcpy(pose.rotation, turn, sizeof turn);
        rotation_normalise(pose.rotation);
    }
    place(forearm, &pose);
}

void bodies_place(bodies_t *self, const scenario_t *scenario, const scene_t *scene) {
    place_robot(self->robot, scenario, scene);
    for (size_t i = 0; i < scenario->person_count; i++) {
        const person_t *who = &scenario->person[i];
        rigid_pose_t hand;
        scene_hand(scene, i, &hand);
        place(&self->person[i][PERSON_PART_HAND], &hand);
        place_forearm(self, i, &hand, who->elbow_m);
        if (who->cup.present) {
            const rigid_pose_t cup = rigid_pose_multiply(&hand, &who->cup.mount);
            place_cup(&self->person[i][PERSON_PART_CUP], &who->cup, &cup);
        }
        place_held(&self->person[i][PERSON_PART_HELD], scenario, scene, i);
    }
}
