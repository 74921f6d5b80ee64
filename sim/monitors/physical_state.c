#include "physical_state.h"

#include <math.h>
#include <string.h>

static void list_contents(physical_state_t *self, const scenario_t *scenario) {
    self->person_count = scenario->person_count;
    self->object_count = scenario->object_count;
    self->tracked = scenario->tracked;
    self->second = scenario->person_count > 1 ? (int)(1 - scenario->tracked) : PHYSICAL_STATE_NONE;
    self->traced_object = PHYSICAL_STATE_NONE;
    self->crank = PHYSICAL_STATE_NONE;
    for (size_t i = scenario->object_count; i-- > 0;) { /* backwards, so that the first match wins */
        self->traced_object = scenario->object[i].kind != OBJECT_STAND ? (int)i : self->traced_object;
        self->crank = scenario->object[i].kind == OBJECT_CRANK ? (int)i : self->crank;
    }
    self->has_water = scenario->water.particles > 0;
    self->has_robot_cup = scenario->cup.present;
}

static void read_objects(physical_state_t *self, const scenario_t *scenario, const scene_t *scene) {
    for (size_t i = 0; i < self->object_count; i++) {
        scene_object(scene, i, &self->object[i]);
        if (scenario->object[i].kind == OBJECT_CRANK) {
            self->crank_turns[i] = scene_crank_turns(scene, i);
        }
        for (size_t k = 0; k < self->person_count; k++) {
            self->holds[k][i] = scene_holds(scene, k, i);
        }
        self->holds[SCENE_HOLDER_ROBOT][i] = scene_holds(scene, SCENE_HOLDER_ROBOT, i);
    }
}

void physical_state_read(physical_state_t *self, const scenario_t *scenario, const scene_t *scene,
                         const measured_clearance_t *clearance) {
    memset(self, 0, sizeof *self);
    list_contents(self, scenario);
    for (size_t i = 0; i < self->person_count; i++) {
        scene_hand(scene, i, &self->hand[i]);
        scene_hand_force_N(scene, i, self->hand_force_N[i]);
    }
    read_objects(self, scenario, scene);
    self->gripper_opening = scene_gripper_opening(scene);
    self->gripper_force_N = scene_gripper_force_N(scene);
    if (self->has_robot_cup) {
        scene_robot_cup(scene, &self->robot_cup);
    }
    self->water = scene_water(scene);
    self->clearance = *clearance;
}

double physical_state_force_N(const physical_state_t *self, size_t person) {
    const double *f = self->hand_force_N[person];
    return sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
}

bool physical_state_holds_any(const physical_state_t *self, size_t holder) {
    bool holds = false;
    for (size_t i = 0; i < self->object_count; i++) {
        holds = holds || self->holds[holder][i];
    }
    return holds;
}
