/* Algorithm 1: see cooperation.h. */
#include "cooperation.h"

/* A quaternion product for code that is not time-critical. Not inline, so that the callers share one copy. */
__attribute__((noinline)) static quaternion_t product(quaternion_t a, quaternion_t b) {
    return quaternion_multiply(a, b);
}

/* ---- constants of Algorithm 1's loop
 *
 * Let q_H^E be (r, t) now and (r_0, t_0) at the start, c = conj(q_Tv^E), s the scale, q_Hv0^H0 = (r_v, t_v), and p_0
 * the virtual hand's translation at the start. Algorithm 1 up to equation (7) then yields a virtual hand with
 *
 *     rotation c r r_v,       translation p_0 + s R(c) (t - t_0).
 *
 * With q_task = (r_k, t_k), the target q_Hv^Tv conj(q_task) has the rotation r' = c r r_v conj(r_k), and its
 * translation is that of the virtual hand minus R(r') t_k. */

/* Computes the 4 x 4 matrix that maps a quaternion r, as (w, x, y, z), to the product `left` r `right`. The columns of
 * the matrix are the images of 1, i, j and k. */
static void fold_rotation(quaternion_t left, quaternion_t right, float turn[4][4]) {
    const quaternion_t times_unit[4] = {
        left,
        {-left.x, left.w, left.z, -left.y},
        {-left.y, -left.z, left.w, left.x},
        {-left.z, left.y, -left.x, left.w},
    };
    for (int column = 0; column < 4; column++) {
        const quaternion_t turned = product(times_unit[column], right);
        turn[0][column] = turned.w;
        turn[1][column] = turned.x;
        turn[2][column] = turned.y;
        turn[3][column] = turned.z;
    }
}

/* Computes the 3 x 3 matrix that rotates a vector by `rotation` and multiplies it by `scale`. */
static void fold_displacement(quaternion_t rotation, float scale, float carry[3][3]) {
    const float w = rotation.w, x = rotation.x, y = rotation.y, z = rotation.z;
    const float twice = scale + scale;
    const float ww = w * w - 0.5f, xx = x * x, yy = y * y, zz = z * z;
    const float wx = w * x, wy = w * y, wz = w * z, xy = x * y, xz = x * z, yz = y * z;
    carry[0][0] = twice * (ww + xx);
    carry[0][1] = twice * (xy - wz);
    carry[0][2] = twice * (xz + wy);
    carry[1][0] = twice * (xy + wz);
    carry[1][1] = twice * (ww + yy);
    carry[1][2] = twice * (yz - wx);
    carry[2][0] = twice * (xz - wy);
    carry[2][1] = twice * (yz + wx);
    carry[2][2] = twice * (ww + zz);
}

/* ---- start and changes */

/* Returns conj(a) b, which is the pose b in the frame a. The rotation is normalised, so that rounding errors do not
 * accumulate over successive changes of the relation. */
static pose_t seen_from(pose_t a, pose_t b) {
    const quaternion_t back = quaternion_conjugate(a.rotation);
    const vector3_t way = vector3_add(b.translation_m, vector3_scale(a.translation_m, -1.0f));
    return (pose_t){quaternion_normalise(product(back, b.rotation)), quaternion_rotate(back, way)};
}

/* Returns the virtual hand's pose at the start, q_Rv0^Tv q_inv: the end effector's pose, moved by the start offset and
 * rotated by q_inv. */
static pose_t virtual_hand_at_start(const cooperation_t *self, pose_t robot) {
    return (pose_t){
        product(robot.rotation, self->task.q_inv),
        vector3_add(robot.translation_m, self->config.start_offset_m),
    };
}

/* Makes `hand` and `virtual_hand` the references for displacements. The last line of Algorithm 1's initialisation
 * computes the pose q_Hv0^H0 = conj(q_H0^Tv) q_Hv0^Tv; only the rotation of this pose is stored, because the loop does
 * not need the translation. */
static void take_reference(cooperation_t *self, pose_t hand, pose_t virtual_hand) {
    const quaternion_t from_tracker = quaternion_conjugate(self->config.tracker_rotation);
    const quaternion_t hand_in_torso = product(from_tracker, hand.rotation); /* equation (8) */
    self->virtual_hand_start = product(quaternion_conjugate(hand_in_torso), virtual_hand.rotation);
    self->settled = false;
    self->loop.hand_start_m = hand.translation_m;
    self->loop.virtual_hand_start_m = virtual_hand.translation_m;
    self->forward_displacement_m = 0.0f;
}

/* Returns the latest pose of the virtual hand, q_Hv^Tv = q_R^Tv q_task. */
static pose_t virtual_hand(const cooperation_t *self) {
    return pose_multiply(self->target, task_relation_at(&self->relation, self->forward_displacement_m));
}

/* Returns the q_task of equation (1) for these poses of the end effector and the virtual hand. */
static task_relation_t performed_relation(pose_t robot, pose_t hand) {
    return (task_relation_t){seen_from(robot, hand), 0.0f};
}

static task_relation_t relation_in_force(const cooperation_t *self, float blend) {
    if (self->latched) {
        return self->relation;
    }
    task_relation_t relation = task_relation(&self->task);
    return blend < 1.0f ? task_relation_interpolate(&self->blend_from, &relation, blend) : relation;
}

void cooperation_start(cooperation_t *self, const cooperation_config_t *config, const task_t *task, pose_t hand,
                       pose_t robot) {
    self->config = *config;
    self->task = *task;
    self->latched = false;
    fold_displacement(quaternion_conjugate(config->tracker_rotation), config->motion_scale, self->loop.carry);
    self->loop.unscale = 1.0f / config->motion_scale;
    const pose_t reference = virtual_hand_at_start(self, robot);
    take_reference(self, hand, reference);
    self->blend_from = performed_relation(robot, reference);
    self->relation = self->blend_from;
    self->target = robot;
}

void cooperation_select(cooperation_t *self, const task_t *task) {
    /* q_inv may change with the task, in which case the virtual hand rotates by conj(old q_inv) new q_inv. The present
     * relation is therefore re-expressed with the rotated hand, so that the target does not move. */
    const quaternion_t turn = product(quaternion_conjugate(self->task.q_inv), task->q_inv);
    pose_t turned_hand = virtual_hand(self);
    turned_hand.rotation = product(turned_hand.rotation, turn);
    self->virtual_hand_start = quaternion_normalise(product(self->virtual_hand_start, turn));
    self->settled = false;
    self->task = *task;
    self->latched = false;
    self->blend_from = performed_relation(self->target, turned_hand);
    self->relation = self->blend_from;
}

void cooperation_clutch(cooperation_t *self, pose_t hand, pose_t robot, float blend) {
    self->relation = relation_in_force(self, blend);
    self->target = robot;
    take_reference(self, hand, pose_multiply(robot, self->relation.pose));
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
    latch(self, performed_relation(robot, virtual_hand(self)).pose);
    self->target = robot;
}

/* ---- the loop */

/* Sets self->target. hand_m: position of the person's hand in the tracker frame. r: the target's rotation. */
static inline void set_target(cooperation_t *self, vector3_t hand_m, quaternion_t r) {
    const cooperation_loop_t *loop = &self->loop;
    const float (*carry)[3] = loop->carry;
    const float t_x = hand_m.x - loop->hand_start_m.x;
    const float t_y = hand_m.y - loop->hand_start_m.y;
    const float t_z = hand_m.z - loop->hand_start_m.z;
    const float forward = carry[0][0] * t_x + carry[0][1] * t_y + carry[0][2] * t_z;
    const float left = carry[1][0] * t_x + carry[1][1] * t_y + carry[1][2] * t_z;
    const float up = carry[2][0] * t_x + carry[2][1] * t_y + carry[2][2] * t_z;

    /* R(r) t_k = t_k + r_w 2 v + u x 2 v, where u is the vector part of r, and v = u x t_k */
    const float k_x = self->relation.pose.translation_m.x, k_y = self->relation.pose.translation_m.y;
    const float k_z = self->relation.pose.translation_m.z + self->relation.slope * forward;
    const float v_x = r.y * k_z - r.z * k_y, v_y = r.z * k_x - r.x * k_z, v_z = r.x * k_y - r.y * k_x;
    const float twice_x = v_x + v_x, twice_y = v_y + v_y, twice_z = v_z + v_z;
    self->forward_displacement_m = forward;
    self->relation_m.x = k_x + r.w * twice_x + (r.y * twice_z - r.z * twice_y);
    self->relation_m.y = k_y + r.w * twice_y + (r.z * twice_x - r.x * twice_z);
    self->relation_m.z = k_z + r.w * twice_z + (r.x * twice_y - r.y * twice_x);
    self->target.rotation = r;
    self->target.translation_m.x = loop->virtual_hand_start_m.x + forward - self->relation_m.x;
    self->target.translation_m.y = loop->virtual_hand_start_m.y + left - self->relation_m.y;
    self->target.translation_m.z = loop->virtual_hand_start_m.z + up - self->relation_m.z;
}

/* Updates the target while the relation may still change, for example during a blend. As soon as the relation is
 * constant, also computes the loop's constants. Not inline, so that cooperation_update() need not save registers. */
__attribute__((noinline)) static void update_and_settle(cooperation_t *self, const pose_t *hand, float blend) {
    self->relation = relation_in_force(self, blend);
    const quaternion_t left = quaternion_conjugate(self->config.tracker_rotation);
    const quaternion_t right = product(self->virtual_hand_start, quaternion_conjugate(self->relation.pose.rotation));
    if (self->latched || blend >= 1.0f) {
        self->settled = true;
        fold_rotation(left, right, self->loop.turn);
    }
    set_target(self, hand->translation_m, product(product(left, hand->rotation), right));
}

void cooperation_update(cooperation_t *self, const pose_t *hand, float blend) {
    if (!self->settled) {
        update_and_settle(self, hand, blend);
        return;
    }
    const float (*turn)[4] = (const float (*)[4])self->loop.turn;
    const float w = hand->rotation.w, x = hand->rotation.x, y = hand->rotation.y, z = hand->rotation.z;
    const quaternion_t r = {
        (turn[0][0] * w + turn[0][1] * x) + (turn[0][2] * y + turn[0][3] * z),
        (turn[1][0] * w + turn[1][1] * x) + (turn[1][2] * y + turn[1][3] * z),
        (turn[2][0] * w + turn[2][1] * x) + (turn[2][2] * y + turn[2][3] * z),
        (turn[3][0] * w + turn[3][1] * x) + (turn[3][2] * y + turn[3][3] * z),
    };
    set_target(self, hand->translation_m, r);
}

static vector3_t carried(const float carry[3][3], vector3_t v) {
    return (vector3_t){
        carry[0][0] * v.x + carry[0][1] * v.y + carry[0][2] * v.z,
        carry[1][0] * v.x + carry[1][1] * v.y + carry[1][2] * v.z,
        carry[2][0] * v.x + carry[2][1] * v.y + carry[2][2] * v.z,
    };
}

/* Computes the time derivative of the target that set_target() computes. The target rotates as the hand does, about the
 * virtual hand. */
twist_t cooperation_target_motion(const cooperation_t *self, const twist_t *hand) {
    const float (*carry)[3] = (const float (*)[3])self->loop.carry;
    const vector3_t virtual_hand_mps = carried(carry, hand->velocity_mps);
    const vector3_t turning_radps = vector3_scale(carried(carry, hand->angular_velocity_radps), self->loop.unscale);
    vector3_t relation_mps = vector3_cross(turning_radps, self->relation_m);
    if (self->relation.slope != 0.0f) {
        const quaternion_t r = self->target.rotation;
        const vector3_t hand_z = {2.0f * (r.x * r.z + r.w * r.y), 2.0f * (r.y * r.z - r.w * r.x),
                                  1.0f - 2.0f * (r.x * r.x + r.y * r.y)};
        relation_mps = vector3_add(relation_mps, vector3_scale(hand_z, self->relation.slope * virtual_hand_mps.x));
    }
    return (twist_t){vector3_add(virtual_hand_mps, vector3_scale(relation_mps, -1.0f)), turning_radps};
}
