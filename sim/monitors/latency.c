#include "latency.h"

#include <math.h>
#include <string.h>

#define TICK_NS 1000000
#define TICK_S 1e-3
#define EARLY_TICKS ((uint64_t)-DELAY_FIRST_TICKS)

void latency_init(latency_t *self) {
    memset(self, 0, sizeof *self);
}

static latency_tick_t *past(latency_t *self, uint64_t tick) {
    return &self->past[tick % LATENCY_PAST_TICKS];
}

/* Adds the hand's contribution to the target. If the task mirrors, uses the z axis of the target that the firmware last
 * reported. The delay of this report does not matter, because the displacement along the axis is short and the axis
 * rotates slowly. */
static void add_hand(latency_t *self, latency_tick_t *now, const tick_record_t *tick, const rigid_pose_t *hand,
                     const double gain[3]) {
    const double scale = gain[1];
    const bool mirrors = gain[0] < 0.0;
    const double unit[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    double ahead[3];
    rotation_apply(tick->target.rotation, unit[2], ahead);
    for (int k = 0; k < 3; k++) {
        double column[3];
        rotation_apply(hand->rotation, unit[k], column);
        for (int row = 0; row < 3; row++) {
            now->hand.turn[row][k] = column[row];
        }
        now->hand_m[k] = hand->position_m[k];
        now->hand.scaled_hand_m[k] = scale * hand->position_m[k];
        if (mirrors) {
            now->hand.scaled_hand_m[k] -= 2.0 * scale * (hand->position_m[0] - self->forward_m) * ahead[k];
        }
    }
    now->counts = false;
}

/* Adds the target and the end effector to the record of the target's own tick, because a target is reported some ticks
 * after it was computed. */
static void add_followers(latency_t *self, const tick_record_t *tick, bool followable) {
    if (!tick->has_target || tick->target_ns == self->target_ns) {
        return;
    }
    self->target_ns = tick->target_ns;
    const uint64_t age = (uint64_t)((tick->time_ns - tick->target_ns) / TICK_NS);
    latency_tick_t *then = past(self, self->ticks - age);
    then->counts = followable;
    memcpy(then->follower_m[DELAY_OF_TARGET], tick->target.position_m, sizeof then->follower_m[0]);
    memcpy(then->follower_m[DELAY_OF_ROBOT], tick->hand_at_target.position_m, sizeof then->follower_m[0]);
}

static bool moves(latency_t *self, uint64_t tick) {
    const double *from = past(self, tick - LATENCY_MEAN_TICKS)->hand_m, *to = past(self, tick)->hand_m;
    const double moved_m = sqrt(pow(to[0] - from[0], 2.0) + pow(to[1] - from[1], 2.0) + pow(to[2] - from[2], 2.0));
    return moved_m > LATENCY_MOVES_MPS * LATENCY_MEAN_TICKS * TICK_S;
}

/* Adds a sample of the tick that was -DELAY_FIRST_TICKS ticks ago. The followers in that tick are compared with earlier
 * and later hand poses, because a follower may also be ahead of the hand. Skips the tick unless all these hand poses
 * belong to the current interval. */
static void add_sample(latency_t *self) {
    const uint64_t tick = self->ticks - EARLY_TICKS;
    if (self->ticks < self->stretch_from + DELAY_LAST_TICKS + EARLY_TICKS ||
        tick < self->sampled + LATENCY_SAMPLE_TICKS || !past(self, tick)->counts || !moves(self, tick)) {
        return;
    }
    const delay_hand_t *hand[DELAY_COUNT];
    for (int n = 0; n < DELAY_COUNT; n++) {
        hand[n] = &past(self, self->ticks - (uint64_t)n * DELAY_STEP_TICKS)->hand;
    }
    delay_fit_add(&self->fit, past(self, tick)->follower_m, hand);
    self->sampled = tick;
    self->samples++;
}

void latency_sample(latency_t *self, const tick_record_t *tick, const rigid_pose_t *hand, const double gain[3],
                    int64_t settled_ns, bool followable) {
    self->ticks++;
    if (tick->mode != MODE_COOPERATING || settled_ns != self->settled_ns || tick->time_ns < settled_ns) {
        delay_fit_end_stretch(&self->fit);
        self->stretch_from = self->ticks;
        self->settled_ns = settled_ns;
        self->forward_m = hand->position_m[0];
    }
    add_hand(self, past(self, self->ticks), tick, hand, gain);
    add_followers(self, tick, followable);
    add_sample(self);
}

latency_ms_t latency_end(latency_t *self, const bus_delays_t *bus, double drive_s) {
    delay_fit_end_stretch(&self->fit);
    latency_ms_t latency = {
        .tracker = bus_delays_tracker_ms(bus),
        .bus = bus_delays_pose_ms(bus),
        .command = bus_delays_command_ms(bus),
        .drive = 1e3 * drive_s,
        .estimate = (double)NAN,
        .end_to_end = (double)NAN,
        .moved_s = LATENCY_SAMPLE_TICKS * TICK_S * (double)self->samples,
    };
    if (latency.moved_s >= LATENCY_NEEDED_S) {
        latency.end_to_end = delay_fit_ms(&self->fit, DELAY_OF_ROBOT);
        latency.estimate = delay_fit_ms(&self->fit, DELAY_OF_TARGET) - latency.tracker - latency.bus;
    }
    latency.law =
        latency.end_to_end - latency.tracker - latency.bus - latency.estimate - latency.command - latency.drive;
    return latency;
}
