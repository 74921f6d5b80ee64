#include "cooperation.h"

/* ---- the loop's constants
 *
 * With q_H^E = (r, t), its start (r_0, t_0), the tracker's rotation c = conj(q_Tv^E), the scale s, and q_Hv0^H0 = (r_v, t_v), the
 * lines up to (7) give the virtual hand
 *
 *     rotation c r r_v,       translation p_0 + s R(c) (t - t_0),      p_0 that of the start,
 *
 * and q_Hv^Tv conj(q_task) with q_task = (r_k, t_k) turns r by c from the left and r_v conj(r_k) from the right, and takes t_k, turned
 * by the result, from the translation. */

/* The matrix of r -> left r right on w x y z. Its columns are left 1, left i, left j, left k, times right. */
static void fold_rotation(quaternion_t left, quaternion_t right, float turn[4][4]) {
    const quaternion_t times_unit[4] = {
        left,
        {-left.x, left.w, left.z, -left.y},
        {-left.y, -left.z, left.w, left.x},
        {-left.z, left.y, -left.x, left.w},
    };
    for (int column = 0; column < 4; column++) {
        const quaternion_t turned = quaternion_multiply(times_unit[column], right);
        turn[0][column] = turned.w;
        turn[1][column] = turned.x;
        turn[2][column] = turned.y;
        turn[3][column] = turned.z;
    }
}

static void fold_displacement(quaternion_t rotation, float scale, float carry[3][3]) {
    for (int column = 0; column < 3; column++) {
        const vector3_t unit = {column == 0 ? scale : 0.0f, column == 1 ? scale : 0.0f, column == 2 ? scale : 0.0f};
        const vector3_t carried = quaternion_rotate(rotation, unit);
        carry[0][column] = carried.x;
        carry[1][column] = carried.y;
        carry[2][column] = carried.z;
    }
}

/* What changes with the poses at the start, and with how the person stands. */
static void fold_start(cooperation_t *self) {
    fold_displacement(quaternion_conjugate(self->config.tracker_rotation), self->config.motion_scale, self->loop.carry);
    self->loop.virtual_hand_start_m =
        dual_quaternion_translation(dual_quaternion_multiply(self->hand_start_in_torso, self->virtual_hand_start));
}

/* ---- start, and changes, as the paper writes them */

/* q_R0^T moved by the person's start offset, seen by a person who stands as q_inv says: q_Rv0^Tv q_inv. */
static dual_quaternion_t virtual_hand_at_start(const cooperation_t *self, dual_quaternion_t robot) {
    dual_quaternion_t offset = dual_quaternion_from_pose(quaternion_identity, self->config.start_offset_m);
    dual_quaternion_t q_inv = {self->task.q_inv, {0.0f, 0.0f, 0.0f, 0.0f}};
    return dual_quaternion_multiply(dual_quaternion_multiply(offset, robot), q_inv);
}

static void set_hand_start(cooperation_t *self, pose_t hand) {
    dual_quaternion_t from_tracker = {quaternion_conjugate(self->config.tracker_rotation), {0.0f, 0.0f, 0.0f, 0.0f}};
    self->hand_start_in_torso = dual_quaternion_multiply(from_tracker, pose_to_dual_quaternion(hand)); /* equation (8) */
    self->loop.hand_start_m = hand.translation_m;
    self->forward_displacement_m = 0.0f;
}

static void set_virtual_hand_start(cooperation_t *self, dual_quaternion_t virtual_hand_start) {
    self->virtual_hand_start = virtual_hand_start;
    self->settled = false;
    fold_start(self);
}

/* q_Hv0^H0 = conj(q_H0^Tv) q_Hv0^Tv, the last line of Algorithm 1's initialisation. */
static void place_virtual_hand(cooperation_t *self, dual_quaternion_t virtual_hand) {
    set_virtual_hand_start(self,
                           dual_quaternion_multiply(dual_quaternion_conjugate(self->hand_start_in_torso), virtual_hand));
}

/* q_Hv^Tv of the latest hand: q_R^Tv q_task. */
static dual_quaternion_t virtual_hand(const cooperation_t *self) {
    const pose_t relation = task_relation_at(&self->relation, self->forward_displacement_m);
    return pose_to_dual_quaternion(pose_multiply(self->target, relation));
}

/* Equation (1): q_task of a robot that stands so while the virtual hand is there. */
static task_relation_t performed_relation(dual_quaternion_t robot, dual_quaternion_t hand) {
    dual_quaternion_t relation = dual_quaternion_multiply(dual_quaternion_conjugate(robot), hand);
    return (task_relation_t){pose_from_dual_quaternion(relation), 0.0f};
}

static task_relation_t relation_in_force(const cooperation_t *self, float blend) {
    if (self->latched) {
        return self->relation;
    }
    task_relation_t relation = task_relation(&self->task);
    return blend < 1.0f ? task_relation_interpolate(&self->blend_from, &relation, blend) : relation;
}

void cooperation_start(cooperation_t *self, const cooperation_config_t *config, const task_t *task, pose_t hand, pose_t robot) {
    self->config = *config;
    self->task = *task;
    self->latched = false;
    set_hand_start(self, hand);
    dual_quaternion_t robot_start = pose_to_dual_quaternion(robot);
    dual_quaternion_t virtual_hand_start = virtual_hand_at_start(self, robot_start);
    place_virtual_hand(self, virtual_hand_start);
    self->blend_from = performed_relation(robot_start, virtual_hand_start);
    self->relation = self->blend_from;
    self->target = robot;
}

void cooperation_select(cooperation_t *self, const task_t *task) {
    /* How the person stands may change with the task: the virtual hand turns by conj(old q_inv) new q_inv, and what was
     * the relation until now is expressed by the turned hand, so that the target does not move. */
    dual_quaternion_t turn = {quaternion_multiply(quaternion_conjugate(self->task.q_inv), task->q_inv),
                              {0.0f, 0.0f, 0.0f, 0.0f}};
    dual_quaternion_t turned_hand = dual_quaternion_multiply(virtual_hand(self), turn);
    set_virtual_hand_start(self, dual_quaternion_multiply(self->virtual_hand_start, turn));
    self->task = *task;
    self->latched = false;
    self->blend_from = performed_relation(pose_to_dual_quaternion(self->target), turned_hand);
    self->relation = self->blend_from;
}

void cooperation_clutch(cooperation_t *self, pose_t hand, pose_t robot, float blend) {
    set_hand_start(self, hand);
    self->relation = relation_in_force(self, blend);
    self->target = robot;
    place_virtual_hand(self, virtual_hand(self));
}

static void latch(cooperation_t *self, pose_t relation) {
    self->relation = (task_relation_t){relation, 0.0f};
    self->latched = true;
    self->settled = false;
}

void cooperation_latch(cooperation_t *self) {
    latch(self, task_relation_at(&self->relation, self->forward_displacement_m));
}

void cooperation_latch_measured(cooperation_t *self, pose_t robot) {
    latch(self, performed_relation(pose_to_dual_quaternion(robot), virtual_hand(self)).pose);
}

/* ---- the loop */

/* What changes as long as a task comes into force. Not in line, so that the loop keeps its registers. */
__attribute__((noinline)) static void fold_relation(cooperation_t *self, float blend) {
    self->relation = relation_in_force(self, blend);
    self->settled = self->latched || blend >= 1.0f;
    const quaternion_t right =
        quaternion_multiply(self->virtual_hand_start.primary, quaternion_conjugate(self->relation.pose.rotation));
    fold_rotation(quaternion_conjugate(self->config.tracker_rotation), right, self->loop.turn);
}

void cooperation_update(cooperation_t *self, const pose_t *hand, float blend) {
    if (!self->settled) {
        fold_relation(self, blend);
    }
    const cooperation_loop_t *loop = &self->loop;
    const float(*turn)[4] = loop->turn;
    const float w = hand->rotation.w, x = hand->rotation.x, y = hand->rotation.y, z = hand->rotation.z;
    const quaternion_t r = {
        (turn[0][0] * w + turn[0][1] * x) + (turn[0][2] * y + turn[0][3] * z),
        (turn[1][0] * w + turn[1][1] * x) + (turn[1][2] * y + turn[1][3] * z),
        (turn[2][0] * w + turn[2][1] * x) + (turn[2][2] * y + turn[2][3] * z),
        (turn[3][0] * w + turn[3][1] * x) + (turn[3][2] * y + turn[3][3] * z),
    };
    const float(*carry)[3] = loop->carry;
    const float t_x = hand->translation_m.x - loop->hand_start_m.x;
    const float t_y = hand->translation_m.y - loop->hand_start_m.y;
    const float t_z = hand->translation_m.z - loop->hand_start_m.z;
    const float forward = carry[0][0] * t_x + carry[0][1] * t_y + carry[0][2] * t_z;
    const float left = carry[1][0] * t_x + carry[1][1] * t_y + carry[1][2] * t_z;
    const float up = carry[2][0] * t_x + carry[2][1] * t_y + carry[2][2] * t_z;

    /* R(r) t_k = t_k + r_w 2 v + r x 2 v with v = r x t_k */
    const float k_x = self->relation.pose.translation_m.x, k_y = self->relation.pose.translation_m.y;
    const float k_z = self->relation.pose.translation_m.z + self->relation.slope * forward;
    const float v_x = r.y * k_z - r.z * k_y, v_y = r.z * k_x - r.x * k_z, v_z = r.x * k_y - r.y * k_x;
    const float twice_x = v_x + v_x, twice_y = v_y + v_y, twice_z = v_z + v_z;
    self->forward_displacement_m = forward;
    self->target.rotation = r;
    self->target.translation_m.x =
        loop->virtual_hand_start_m.x + forward - (k_x + r.w * twice_x + (r.y * twice_z - r.z * twice_y));
    self->target.translation_m.y =
        loop->virtual_hand_start_m.y + left - (k_y + r.w * twice_y + (r.z * twice_x - r.x * twice_z));
    self->target.translation_m.z =
        loop->virtual_hand_start_m.z + up - (k_z + r.w * twice_z + (r.x * twice_y - r.y * twice_x));
}
