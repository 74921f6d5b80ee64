#include "scenario_monitor.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void scenario_monitor_init(scenario_monitor_t *self, const scenario_t *scenario) {
    memset(self, 0, sizeof *self);
    self->scenario = scenario;
    for (size_t i = 0; i < SCENARIO_MAX_PEOPLE; i++) {
        char name[EVENT_NAME_BYTES];
        (void)snprintf(name, sizeof name, "%s.lost", scenario->person[i].name);
        self->lost_event[i] = i < scenario->person_count ? events_find(&scenario->events, name) : EVENT_NONE;
    }
    self->lost_event[SCENE_HOLDER_ROBOT] = events_find(&scenario->events, "robot.lost");
    for (size_t i = 0; i < scenario->object_count; i++) {
        char name[EVENT_NAME_BYTES];
        (void)snprintf(name, sizeof name, "%s.dropped", scenario->object[i].name);
        self->dropped_event[i] = events_find(&scenario->events, name);
    }
}

static void read_hands(scenario_monitor_t *self, const physical_state_t *state, measurement_input_t *input) {
    const size_t slot = self->ticks % SCENARIO_MONITOR_PAST_TICKS;
    const double moving_m = SCENARIO_MONITOR_MOVING_MPS * SCENARIO_MONITOR_PAST_TICKS * CHECK_WINDOW_TICK_S;
    for (size_t i = 0; i < state->person_count; i++) {
        double *past_m = self->past_m[slot][i];
        const double *now_m = state->hand[i].position_m;
        const double dx = now_m[0] - past_m[0], dy = now_m[1] - past_m[1], dz = now_m[2] - past_m[2];
        const bool has_past = self->ticks >= SCENARIO_MONITOR_PAST_TICKS;
        input->is_moving[i] = has_past && sqrt(dx * dx + dy * dy + dz * dz) > moving_m;
        memcpy(past_m, now_m, sizeof self->past_m[slot][i]);
    }
}

/* A `lost` event does not name the object. The lost object is the one that the holder held in the previous tick or
 * still holds in `state`, which is read before the event. */
static void read_losses(scenario_monitor_t *self, const physical_state_t *state, const events_t *events,
                        measurement_input_t *input) {
    for (size_t i = 0; i <= SCENARIO_MAX_PEOPLE; i++) {
        const int times = self->lost_event[i] == EVENT_NONE ? 0 : events->event[self->lost_event[i]].times;
        for (size_t k = 0; k < state->object_count; k++) {
            input->lost[k] += state->holds[i][k] || self->held_before[i][k] ? times - self->lost_before[i] : 0;
        }
        self->lost_before[i] = times;
    }
    memcpy(self->held_before, state->holds, sizeof self->held_before);
}

static void read_drops(scenario_monitor_t *self, const events_t *events, measurement_input_t *input) {
    for (size_t i = 0; i < self->scenario->object_count; i++) {
        const int times = self->dropped_event[i] == EVENT_NONE ? 0 : events->event[self->dropped_event[i]].times;
        input->dropped[i] = times - self->dropped_before[i];
        self->dropped_before[i] = times;
    }
}

void scenario_monitor_sample(scenario_monitor_t *self, const tick_record_t *tick, const physical_state_t *state,
                             const events_t *events, double motion_scale) {
    if (!self->has_start && tick->mode == MODE_COOPERATING) {
        self->has_start = true;
        self->start = tick->hand;
    }
    measurement_input_t input = {
        .tick = tick,
        .state = state,
        .events = events,
        .motion_scale = motion_scale,
        .start = self->has_start ? &self->start : NULL,
        .particles = self->scenario->water.particles,
        .newly_left_cup = state->water.left_robot_cup - self->left_cup_before,
    };
    read_losses(self, state, events, &input);
    read_drops(self, events, &input);
    read_hands(self, state, &input);
    for (size_t i = 0; i < self->scenario->check_count; i++) {
        measurement_sample(&self->measurement[i], &self->scenario->check[i], &input);
    }
    self->left_cup_before = state->water.left_robot_cup;
    self->ticks++;
}
