#include "rest_monitor.h"

#include <math.h>
#include <string.h>

#define PHASE_NS ((int64_t)(REST_PHASE_S * 1e9))
#define ARRIVING_NS INT64_C(1000000000)

void rest_monitor_init(rest_monitor_t *self) {
    memset(self, 0, sizeof *self);
    self->anchor.rotation[0] = 1.0;
}

/* ---- the hand in ODE */

static bool is_away(const rigid_pose_t *hand, const rigid_pose_t *anchor) {
    const double dx = hand->position_m[0] - anchor->position_m[0], dy = hand->position_m[1] - anchor->position_m[1];
    const double dz = hand->position_m[2] - anchor->position_m[2];
    return sqrt(dx * dx + dy * dy + dz * dz) > REST_HAND_M ||
           rotation_angle_between(hand->rotation, anchor->rotation) > REST_HAND_RAD;
}

/* If the mean of the block is away from the anchor, the hand has moved. The hand is then taken to have been still only
 * since the start of this block, and the mean becomes the new anchor. While the hand may still be arriving, the anchor
 * follows the mean, because tremor alone could carry the hand away from an anchor that was set during the approach. */
static void end_block(rest_monitor_t *self) {
    rigid_pose_t mean = self->block;
    for (int k = 0; k < 3; k++) {
        mean.position_m[k] /= REST_BLOCK_TICKS;
    }
    rotation_normalise(mean.rotation);
    const bool is_arriving = self->block_ns - self->commanded_ns < ARRIVING_NS;
    if (is_away(&mean, &self->anchor)) {
        self->hand_ns = self->block_ns;
    }
    if (self->hand_ns == self->block_ns || is_arriving) {
        self->anchor = mean;
    }
    self->block_ticks = 0;
}

static void add_hand(rest_monitor_t *self, int64_t now_ns, const rigid_pose_t *hand) {
    if (self->block_ticks == 0) {
        self->block = (rigid_pose_t){.position_m = {0.0}};
        self->block_ns = now_ns;
    }
    rigid_pose_t near = *hand;
    if (self->block_ticks > 0) {
        rigid_pose_choose_side(&near, &self->block);
    }
    for (int k = 0; k < 3; k++) {
        self->block.position_m[k] += near.position_m[k];
    }
    for (int k = 0; k < 4; k++) {
        self->block.rotation[k] += near.rotation[k];
    }
    if (++self->block_ticks == REST_BLOCK_TICKS) {
        end_block(self);
    }
}

/* ---- phases */

static double last_speed_radps(const rest_monitor_t *self) {
    double largest_radps = 0.0;
    for (int n = 0; n < REST_WINDOW_TICKS; n++) {
        largest_radps = fmax(largest_radps, (double)self->speed_radps[n]);
    }
    return largest_radps;
}

static void end_phase(rest_monitor_t *self) {
    if (self->phase_s >= REST_PHASE_S) {
        self->measured = true;
        self->speed_radps_max = fmax(self->speed_radps_max, last_speed_radps(self));
    }
    self->phase_s = 0.0;
}

/* Ends the period in which the hand is commanded to be still. */
static void end_commanded_rest(rest_monitor_t *self, int64_t now_ns) {
    const bool moved_to_the_end = (double)(now_ns - self->hand_ns) * 1e-9 < REST_UNSTILL_S;
    self->disturbed = self->disturbed || (now_ns - self->commanded_ns >= PHASE_NS && moved_to_the_end);
    end_phase(self);
}

/* Returns true if nothing that would move the target has changed since the previous tick. */
static bool is_rest_commanded(const rest_monitor_t *self, const tick_record_t *tick, const physical_state_t *state,
                              const rigid_pose_t *aim, int64_t settled_ns) {
    return tick->mode == MODE_COOPERATING && self->mode == MODE_COOPERATING && settled_ns == self->settled_ns &&
           tick->time_ns >= settled_ns && memcmp(aim, &self->aim, sizeof *aim) == 0 &&
           memcmp(state->holds, self->holds, sizeof self->holds) == 0;
}

static double fastest_radps(const tick_record_t *tick) {
    double fastest = 0.0;
    for (int i = 0; tick->has_command && i < ROBOT_JOINTS; i++) {
        fastest = fmax(fastest, fabs((double)tick->command.velocity_radps[i]));
    }
    return fastest;
}

void rest_monitor_sample(rest_monitor_t *self, const tick_record_t *tick, const physical_state_t *state,
                         const rigid_pose_t *aim, int64_t settled_ns) {
    const int64_t now_ns = tick->time_ns, hand_ns = self->hand_ns;
    add_hand(self, now_ns, &state->hand[state->tracked]);
    if (!is_rest_commanded(self, tick, state, aim, settled_ns)) {
        end_commanded_rest(self, now_ns);
        self->commanded_ns = now_ns;
    } else if (self->hand_ns != hand_ns) {
        end_phase(self);
    }
    self->mode = tick->mode;
    self->settled_ns = settled_ns;
    self->aim = *aim;
    memcpy(self->holds, state->holds, sizeof self->holds);
    self->speed_radps[self->ticks++ % REST_WINDOW_TICKS] = (float)fastest_radps(tick);
    const int64_t since_ns = self->hand_ns > self->commanded_ns ? self->hand_ns : self->commanded_ns;
    self->phase_s = (double)(now_ns - since_ns) * 1e-9;
    self->longest_s = fmax(self->longest_s, self->phase_s);
}

void rest_monitor_end(rest_monitor_t *self, int64_t now_ns) {
    end_commanded_rest(self, now_ns);
    self->commanded_ns = now_ns;
}
