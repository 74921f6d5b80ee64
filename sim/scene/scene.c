#include "scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "grip.h"
#include "hand_body.h"
#include "objects.h"
#include "physics.h"
#include "support.h"

#define HAND_CAPTURE_M 0.025  /* an open hand can grip an object whose axis is this close to the grip point */
#define OPENING_ON_OBJECT 0.3 /* opening at which the jaws touch an object */
#define DROPPED_AFTER_S 0.02  /* an object counts as dropped after nobody has held it for this long */
#define HOLDERS (SCENARIO_MAX_PEOPLE + 1)

struct scene {
    const scenario_t *scenario;
    events_t *events;
    dWorldID world;
    dJointGroupID contacts;
    arm_plant_t *arm;
    hand_body_t hand[SCENARIO_MAX_PEOPLE];
    scene_object_t object[SCENARIO_MAX_OBJECTS];
    grip_t grip[HOLDERS];
    struct {
        bool was_held;
        bool is_dropped;
        double unheld_s;
    } hold_state[SCENARIO_MAX_OBJECTS];
    double now_s; /* at the end of the last step */
    bool close;   /* the last gripper command */
    double opening;
    water_body_t *water;
    int person_with_cup; /* -1 if there is none */
};

/* ---- events */

static void raise_event(scene_t *self, const char *actor, const char *what, double now_s) {
    char name[EVENT_NAME_BYTES + SCENARIO_NAME_BYTES];
    (void)snprintf(name, sizeof name, "%s.%s", actor, what);
    events_raise(self->events, events_find(self->events, name), now_s);
}

static const char *holder_name(const scene_t *self, size_t holder) {
    return holder == SCENE_HOLDER_ROBOT ? "robot" : self->scenario->person[holder].name;
}

/* ---- set-up */

static void cup_poses(const scene_t *self, rigid_pose_t pose[WATER_MAX_CUPS]) {
    const rigid_pose_t nowhere = {{0.0, 0.0, -10.0}, {1.0, 0.0, 0.0, 0.0}};
    scene_robot_cup(self, &pose[0]);
    pose[1] = nowhere;
    if (self->person_with_cup >= 0) {
        rigid_pose_t hand;
        scene_hand(self, (size_t)self->person_with_cup, &hand);
        pose[1] = rigid_pose_multiply(&hand, &self->scenario->person[self->person_with_cup].cup.mount);
    }
}

static bool create_water(scene_t *self) {
    const scenario_t *scenario = self->scenario;
    if (scenario->water.particles == 0) {
        return true;
    }
    cup_t cups[WATER_MAX_CUPS] = {scenario->cup};
    if (self->person_with_cup >= 0) {
        cups[1] = scenario->person[self->person_with_cup].cup;
    }
    rigid_pose_t pose[WATER_MAX_CUPS];
    cup_poses(self, pose);
    self->water = water_create(&scenario->water, cups, pose, OBJECTS_GROUND_Z_M);
    return self->water != NULL;
}

static void create_people(scene_t *self) {
    self->person_with_cup = -1;
    for (size_t i = self->scenario->person_count;
         i-- > 0;) { /* backwards, so that the first person with a cup counts */
        const person_t *person = &self->scenario->person[i];
        hand_body_init(&self->hand[i], self->world, person);
        self->grip[i].properties = (grip_properties_t){.force_limit_N = person->grip_force_limit_N};
        self->person_with_cup = person->cup.present ? (int)i : self->person_with_cup;
    }
}

static void gripper_point(const scene_t *self, double position_m[3]) {
    const point_t point = {.kind = POINT_ROBOT_GRIPPER};
    scene_point(self, &point, position_m);
}

static void robot_grips(scene_t *self, size_t object) {
    double point[3];
    gripper_point(self, point);
    grip_close(&self->grip[SCENE_HOLDER_ROBOT], self->world, arm_plant_hand_body(self->arm), self->object, object,
               self->scenario->object[object].robot_grip, point);
}

static void create_objects(scene_t *self) {
    const gripper_t *gripper = &self->scenario->gripper;
    self->grip[SCENE_HOLDER_ROBOT].properties = (grip_properties_t){gripper->stiffness_Npm, gripper->damping_Nspm,
                                                                    gripper->force_limit_N, gripper->torque_limit_Nm};
    self->opening = 1.0;
    for (size_t i = 0; i < self->scenario->object_count; i++) {
        scene_object_init(&self->object[i], self->world, &self->scenario->object[i]);
    }
    for (size_t i = 0; i < self->scenario->object_count; i++) {
        if (self->scenario->object[i].held_by_robot) {
            self->close = true;
            self->opening = OPENING_ON_OBJECT;
            self->hold_state[i].was_held = true;
            robot_grips(self, i);
        }
    }
}

scene_t *scene_create(const scenario_t *scenario, events_t *events) {
    scene_t *self = calloc(1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    double start_rad[ROBOT_JOINTS];
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        start_rad[i] = scenario->start_deg[i] * ROBOT_RAD_PER_DEG;
    }
    self->scenario = scenario;
    self->events = events;
    self->world = physics_create();
    self->contacts = dJointGroupCreate(0);
    self->arm = arm_plant_create(self->world, start_rad);
    if (self->arm == NULL) {
        scene_destroy(self);
        return NULL;
    }
    create_people(self);
    create_objects(self);
    if (!create_water(self)) {
        scene_destroy(self);
        return NULL;
    }
    return self;
}

void scene_destroy(scene_t *self) {
    if (self != NULL) {
        water_destroy(self->water);
        dJointGroupDestroy(self->contacts);
        arm_plant_destroy(self->arm);
        physics_destroy(self->world);
        free(self);
    }
}

/* ---- a step */

/* Returns the object between the closing jaws, or the number of objects if there is none. */
static size_t object_between_jaws(const scene_t *self) {
    double point[3], nearest[3];
    gripper_point(self, point);
    for (size_t i = 0; i < self->scenario->object_count; i++) {
        if (self->object[i].body != NULL &&
            scene_object_nearest(&self->object[i], point, nearest) <= self->scenario->gripper.capture_m) {
            return i;
        }
    }
    return self->scenario->object_count;
}

static void close_jaws(scene_t *self, double now_s, double stroke) {
    const double before = self->opening;
    self->opening = fmax(0.0, before - stroke);
    if (before > OPENING_ON_OBJECT && self->opening <= OPENING_ON_OBJECT) {
        const size_t object = object_between_jaws(self);
        if (object < self->scenario->object_count) {
            robot_grips(self, object);
            self->opening = OPENING_ON_OBJECT;
            raise_event(self, "robot", "holds", now_s);
        }
    }
    if (before > 0.0 && self->opening <= 0.0) {
        raise_event(self, "robot", "closed", now_s);
    }
}

static void open_jaws(scene_t *self, double now_s, double stroke) {
    const double before = self->opening;
    grip_open(&self->grip[SCENE_HOLDER_ROBOT]);
    self->opening = fmin(1.0, before + stroke);
    if (before < 1.0 && self->opening >= 1.0) {
        raise_event(self, "robot", "opened", now_s);
    }
}

static void move_jaws(scene_t *self, double now_s, double step_s) {
    const double stroke = step_s / self->scenario->gripper.stroke_s;
    if (!self->close) {
        open_jaws(self, now_s, stroke);
    } else if (!scene_robot_holds(self)) {
        close_jaws(self, now_s, stroke);
    }
}

static void check_grips(scene_t *self, double now_s, double step_s) {
    for (size_t i = 0; i < HOLDERS; i++) {
        if (!grip_hold(&self->grip[i], step_s)) {
            raise_event(self, holder_name(self, i), "lost", now_s);
        }
    }
}

static bool is_held(const scene_t *self, size_t object) {
    bool held = false;
    for (size_t i = 0; i < HOLDERS; i++) {
        held = held || scene_holds(self, i, object);
    }
    return held;
}

static void check_drops(scene_t *self, double now_s, double step_s) {
    for (size_t i = 0; i < self->scenario->object_count; i++) {
        if (is_held(self, i)) {
            self->hold_state[i].was_held = true;
            self->hold_state[i].is_dropped = false;
            self->hold_state[i].unheld_s = 0.0;
        } else if (self->hold_state[i].was_held && !self->hold_state[i].is_dropped) {
            self->hold_state[i].unheld_s += step_s;
            if (self->hold_state[i].unheld_s >= DROPPED_AFTER_S) {
                self->hold_state[i].is_dropped = true;
                raise_event(self, self->scenario->object[i].name, "dropped", now_s);
            }
        }
    }
}

void scene_step(scene_t *self, double now_s, double step_s) {
    move_jaws(self, now_s, step_s);
    for (size_t i = 0; i < self->scenario->person_count; i++) {
        hand_body_push(&self->hand[i], step_s);
    }
    for (size_t i = 0; i < self->scenario->object_count; i++) {
        scene_object_prepare(&self->object[i]);
    }
    for (size_t i = 0; i < HOLDERS; i++) {
        grip_prepare(&self->grip[i], step_s);
    }
    support_collide(self->world, self->contacts, self->object, self->scenario->object_count, step_s);
    physics_step(self->world, step_s);
    dJointGroupEmpty(self->contacts);
    check_grips(self, now_s, step_s);
    check_drops(self, now_s, step_s);
    self->now_s = now_s + step_s;
    if (self->water != NULL) {
        rigid_pose_t pose[WATER_MAX_CUPS];
        cup_poses(self, pose);
        water_step(self->water, pose, step_s);
    }
}

/* ---- robot */

arm_plant_t *scene_arm(const scene_t *self) {
    return self->arm;
}

void scene_command_gripper(scene_t *self, bool close) {
    self->close = close;
}

double scene_gripper_opening(const scene_t *self) {
    return self->opening;
}

bool scene_robot_holds(const scene_t *self) {
    return self->grip[SCENE_HOLDER_ROBOT].joint != NULL;
}

double scene_gripper_force_N(const scene_t *self) {
    return scene_robot_holds(self) ? self->grip[SCENE_HOLDER_ROBOT].load_N : 0.0;
}

void scene_robot_cup(const scene_t *self, rigid_pose_t *cup) {
    rigid_pose_t hand;
    arm_plant_hand(self->arm, &hand);
    *cup = rigid_pose_multiply(&hand, &self->scenario->cup.mount);
}

/* ---- people */

void scene_aim_hand(scene_t *self, size_t person, const rigid_pose_t *hand) {
    self->hand[person].next_aim = *hand;
}

void scene_hand(const scene_t *self, size_t person, rigid_pose_t *hand) {
    hand_body_pose(&self->hand[person], hand);
}

bool scene_close_hand(scene_t *self, size_t person, size_t object) {
    const point_t palm = {.kind = POINT_PERSON_GRIP, .index = person};
    double point[3], nearest[3];
    scene_point(self, &palm, point);
    if (self->grip[person].joint != NULL || self->object[object].body == NULL ||
        scene_object_nearest(&self->object[object], point, nearest) > HAND_CAPTURE_M) {
        return false;
    }
    grip_close(&self->grip[person], self->world, self->hand[person].body, self->object, object,
               self->scenario->object[object].person_grip, point);
    raise_event(self, self->scenario->person[person].name, "holds", self->now_s);
    return true;
}

void scene_open_hand(scene_t *self, size_t person) {
    grip_open(&self->grip[person]);
}

void scene_hand_force_N(const scene_t *self, size_t person, double force_N[3]) {
    grip_force_N(&self->grip[person], force_N);
}

/* ---- objects */

void scene_object(const scene_t *self, size_t object, rigid_pose_t *pose) {
    scene_object_pose(&self->object[object], pose);
}

bool scene_holds(const scene_t *self, size_t holder, size_t object) {
    return self->grip[holder].joint != NULL && self->grip[holder].object == object;
}

double scene_crank_turns(const scene_t *self, size_t object) {
    return self->object[object].hinge_angle_rad / (2.0 * ROBOT_PI);
}

static void point_on_hand(const rigid_pose_t *hand, const double offset_m[3], double position_m[3]) {
    rotation_apply(hand->rotation, offset_m, position_m);
    for (int k = 0; k < 3; k++) {
        position_m[k] += hand->position_m[k];
    }
}

void scene_point(const scene_t *self, const point_t *point, double position_m[3]) {
    rigid_pose_t hand;
    switch (point->kind) {
    case POINT_OBJECT:
        scene_object_point(&self->object[point->index],
                           self->scenario->object[point->index].point[point->point].along_m, position_m);
        break;
    case POINT_PERSON_GRIP:
        scene_hand(self, point->index, &hand);
        point_on_hand(&hand, self->scenario->person[point->index].grip_m, position_m);
        break;
    case POINT_ROBOT_GRIPPER:
        arm_plant_hand(self->arm, &hand);
        point_on_hand(&hand, self->scenario->gripper.offset_m, position_m);
        break;
    case POINT_NONE: break;
    }
}

water_count_t scene_water(const scene_t *self) {
    const water_count_t none = {0, 0, 0, 0};
    return self->water != NULL ? water_count(self->water) : none;
}
