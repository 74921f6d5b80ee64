#include "cooperation.h"

/* q_R0^T moved by the person's start offset, seen by a person who stands as q_inv says: q_Rv0^Tv q_inv. */
static dual_quaternion_t virtual_hand_at_start(const cooperation_t *self, dual_quaternion_t robot) {
    dual_quaternion_t offset = dual_quaternion_from_pose(quaternion_identity, self->config.start_offset_m);
    dual_quaternion_t q_inv = {self->task.q_inv, {0.0f, 0.0f, 0.0f, 0.0f}};
    return dual_quaternion_multiply(dual_quaternion_multiply(offset, robot), q_inv);
}

/* q_Hv0^H0 = conj(q_H0^Tv) q_Hv0^Tv, the last line of Algorithm 1's initialisation. */
static void place_virtual_hand(cooperation_t *self, dual_quaternion_t virtual_hand) {
    self->virtual_hand_start =
        dual_quaternion_multiply(dual_quaternion_conjugate(self->hand_start_in_torso), virtual_hand);
    self->virtual_hand = virtual_hand;
}

static void set_hand_start(cooperation_t *self, dual_quaternion_t hand) {
    dual_quaternion_t from_tracker = {quaternion_conjugate(self->config.tracker_rotation), {0.0f, 0.0f, 0.0f, 0.0f}};
    self->hand_start = hand;
    self->hand_start_in_torso = dual_quaternion_multiply(from_tracker, hand); /* equation (8) */
    self->forward_displacement_m = 0.0f;
}

/* q_H^H0, its translation scaled. */
static dual_quaternion_t hand_motion(const cooperation_t *self, dual_quaternion_t hand) {
    dual_quaternion_t motion = dual_quaternion_multiply(dual_quaternion_conjugate(self->hand_start), hand);
    vector3_t t = dual_quaternion_translation(motion);
    float scale = self->config.motion_scale;
    return dual_quaternion_from_pose(motion.primary, (vector3_t){scale * t.x, scale * t.y, scale * t.z});
}

static dual_quaternion_t relation_in_force(const cooperation_t *self, float blend) {
    if (self->latched) {
        return self->latched_relation;
    }
    dual_quaternion_t relation = task_relation(&self->task, self->forward_displacement_m);
    return blend < 1.0f ? dual_quaternion_interpolate(self->blend_from, relation, blend) : relation;
}

void cooperation_start(cooperation_t *self, const cooperation_config_t *config, const task_t *task,
                       dual_quaternion_t hand, dual_quaternion_t robot) {
    self->config = *config;
    self->task = *task;
    self->latched = false;
    set_hand_start(self, hand);
    place_virtual_hand(self, virtual_hand_at_start(self, robot));
    /* equation (1) for the robot as it stands */
    self->blend_from = dual_quaternion_multiply(dual_quaternion_conjugate(robot), self->virtual_hand);
    self->relation = self->blend_from;
}

void cooperation_select(cooperation_t *self, const task_t *task) {
    dual_quaternion_t target =
        dual_quaternion_multiply(self->virtual_hand, dual_quaternion_conjugate(self->relation));
    /* How the person stands may change with the task: the virtual hand turns by conj(old q_inv) new q_inv, and what was
     * the relation until now is expressed by the turned hand, so that the target does not move. */
    dual_quaternion_t turn = {quaternion_multiply(quaternion_conjugate(self->task.q_inv), task->q_inv),
                              {0.0f, 0.0f, 0.0f, 0.0f}};
    self->virtual_hand_start = dual_quaternion_multiply(self->virtual_hand_start, turn);
    self->virtual_hand = dual_quaternion_multiply(self->virtual_hand, turn);
    self->task = *task;
    self->latched = false;
    self->blend_from = dual_quaternion_multiply(dual_quaternion_conjugate(target), self->virtual_hand);
    self->relation = self->blend_from;
}

void cooperation_clutch(cooperation_t *self, dual_quaternion_t hand, dual_quaternion_t robot, float blend) {
    set_hand_start(self, hand);
    self->relation = relation_in_force(self, blend);
    place_virtual_hand(self, dual_quaternion_multiply(robot, self->relation));
}

void cooperation_latch(cooperation_t *self) {
    self->latched_relation = self->relation;
    self->latched = true;
}

void cooperation_latch_measured(cooperation_t *self, dual_quaternion_t robot) {
    self->latched_relation = dual_quaternion_multiply(dual_quaternion_conjugate(robot), self->virtual_hand);
    self->relation = self->latched_relation;
    self->latched = true;
}

dual_quaternion_t cooperation_target(cooperation_t *self, dual_quaternion_t hand, float blend) {
    dual_quaternion_t motion = hand_motion(self, hand);
    /* x_H - x_H0 in torso axes: q_H^H0's translation turned from H0's axes to the torso's */
    self->forward_displacement_m =
        quaternion_rotate(self->hand_start_in_torso.primary, dual_quaternion_translation(motion)).x;
    dual_quaternion_t virtual_hand_from_start =
        dual_quaternion_decompositional_multiply(self->virtual_hand_start, motion);
    self->virtual_hand = dual_quaternion_multiply(self->hand_start_in_torso, virtual_hand_from_start); /* (7) */
    self->relation = relation_in_force(self, blend);
    dual_quaternion_t target =
        dual_quaternion_multiply(self->virtual_hand, dual_quaternion_conjugate(self->relation));
    return dual_quaternion_normalise(target);
}
