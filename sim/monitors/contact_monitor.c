#include "contact_monitor.h"

#include <math.h>
#include <string.h>

void contact_monitor_init(contact_monitor_t *self) {
    memset(self, 0, sizeof *self);
    self->person = (least_clearance_t){.least_m = (double)INFINITY, .pair = -1};
    self->self = self->person;
}

static void keep_least(least_clearance_t *self, double clearance_m, int pair, double t_s) {
    if (clearance_m < self->least_m) {
        *self = (least_clearance_t){clearance_m, pair, t_s};
    }
}

static void add_force(held_force_t *self, double force_N) {
    self->ticks++;
    self->square_N2 += force_N * force_N;
    self->peak_N = isnan(force_N) ? force_N : force_N > self->peak_N ? force_N : self->peak_N; /* keeps NaN */
}

void contact_monitor_sample(contact_monitor_t *self, const tick_record_t *tick, const physical_state_t *state) {
    const double t_s = (double)tick->time_ns * 1e-9;
    keep_least(&self->person, state->clearance.person_m, state->clearance.person_pair, t_s);
    keep_least(&self->self, state->clearance.self_m, state->clearance.self_pair, t_s);
    for (size_t i = 0; i < state->person_count; i++) {
        if (physical_state_holds_any(state, i)) {
            add_force(&self->hand[i], physical_state_force_N(state, i));
        }
    }
    if (physical_state_holds_any(state, SCENE_HOLDER_ROBOT)) {
        add_force(&self->gripper, state->gripper_force_N);
    }
}

double held_force_rms_N(const held_force_t *self) {
    return self->ticks > 0 ? sqrt(self->square_N2 / (double)self->ticks) : (double)NAN;
}

double held_force_peak_N(const held_force_t *self) {
    return self->ticks > 0 ? self->peak_N : (double)NAN;
}
