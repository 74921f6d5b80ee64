/* Implements, without physics, the functions of scene.h that the programs of the simulated people call. */
#include "stand_in_scene.h"

#include <stdlib.h>

struct scene {
    const scenario_t *scenario;
    fake_state_t state;
};

scene_t *scene_create(const scenario_t *scenario, events_t *events) {
    (void)events;
    scene_t *self = calloc(1, sizeof *self);
    self->scenario = scenario;
    for (size_t i = 0; i < SCENARIO_MAX_PEOPLE; i++) {
        self->state.hand[i] = scenario->person[i].start;
    }
    for (size_t i = 0; i < SCENARIO_MAX_OBJECTS; i++) {
        self->state.object[i] = scenario->object[i].pose;
    }
    return self;
}

void scene_destroy(scene_t *self) {
    free(self);
}

fake_state_t *stand_in_scene_state(scene_t *self) {
    return &self->state;
}

void scene_aim_hand(scene_t *self, size_t person, const rigid_pose_t *hand) {
    self->state.hand[person] = *hand;
    for (int i = 0; i < 3; i++) {
        self->state.hand[person].position_m[i] += self->state.sag_m[person][i];
    }
}

bool scene_close_hand(scene_t *self, size_t person, size_t object) {
    (void)person;
    (void)object;
    self->state.closings++;
    return self->state.can_grip;
}

bool scene_holds(const scene_t *self, size_t holder, size_t object) {
    return holder == 0 && self->state.holds[object];
}

void scene_open_hand(scene_t *self, size_t person) {
    (void)person;
    self->state.openings++;
}

void scene_object(const scene_t *self, size_t object, rigid_pose_t *pose) {
    *pose = self->state.object[object];
}

double scene_crank_turns(const scene_t *self, size_t object) {
    (void)object;
    return self->state.crank_turns;
}

static void apply(const rigid_pose_t *pose, const double point_m[3], double position_m[3]) {
    rotation_apply(pose->rotation, point_m, position_m);
    for (int i = 0; i < 3; i++) {
        position_m[i] += pose->position_m[i];
    }
}

void scene_point(const scene_t *self, const point_t *point, double position_m[3]) {
    const scenario_t *scenario = self->scenario;
    const size_t index = point->index;
    if (point->kind == POINT_PERSON_GRIP) {
        apply(&self->state.hand[index], scenario->person[index].grip_m, position_m);
    } else if (point->kind == POINT_OBJECT) {
        const double along_m[3] = {0.0, 0.0, scenario->object[index].point[point->point].along_m};
        apply(&self->state.object[index], along_m, position_m);
    } else {
        for (int i = 0; i < 3; i++) {
            const double displacement_m = self->state.hand[0].position_m[i] - scenario->person[0].start.position_m[i];
            position_m[i] = self->state.gripper_start_m[i] + self->state.gripper_follows[i] * displacement_m;
        }
    }
}
