#include "check_window.h"

#include <math.h>

#include "measure.h"

#define HALF_A_TICK_S (0.5 * CHECK_WINDOW_TICK_S)

static double moment_s(const moment_t *moment, const events_t *events) {
    if (moment->event == EVENT_NONE) {
        return moment->s;
    }
    const event_t *event = &events->event[moment->event];
    return event->times > 0 ? event->first_s + moment->s : (double)INFINITY;
}

static double begin_s(const check_window_t *self, const scenario_check_t *check, const events_t *events) {
    if (check->has_from) {
        return moment_s(&check->from, events);
    }
    return self->has_started || measure_is_of_whole_run(check->measure) ? 0.0 : (double)INFINITY;
}

static bool is_before_the_stop(const scenario_check_t *check, control_mode_t mode) {
    return check->has_until || measure_is_of_whole_run(check->measure) || mode == MODE_COOPERATING || mode == MODE_HOLD;
}

bool check_window_contains(check_window_t *self, const scenario_check_t *check, double t_s, control_mode_t mode,
                           const events_t *events) {
    const double until_s = check->has_until ? moment_s(&check->until, events) : (double)INFINITY;
    self->has_started = self->has_started || mode == MODE_COOPERATING;
    self->is_open = self->is_open || t_s >= begin_s(self, check, events) - HALF_A_TICK_S;
    self->is_closed = self->is_closed || t_s + HALF_A_TICK_S >= until_s;
    if (!self->is_open || t_s >= until_s + HALF_A_TICK_S || !is_before_the_stop(check, mode)) {
        return false;
    }
    self->first_s = self->ticks == 0 ? t_s : self->first_s;
    self->last_s = t_s;
    self->ticks++;
    return true;
}

bool check_window_is_whole(const check_window_t *self, const scenario_check_t *check) {
    return (!check->has_from || self->is_open) && (!check->has_until || self->is_closed);
}

static bool is_missing(bool is_named, const moment_t *moment, const events_t *events) {
    return is_named && moment->event != EVENT_NONE && !events_happened(events, moment->event);
}

int check_window_missing_event(const check_window_t *self, const scenario_check_t *check, const events_t *events) {
    if (is_missing(check->has_from && !self->is_open, &check->from, events)) {
        return check->from.event;
    }
    return is_missing(check->has_until && !self->is_closed, &check->until, events) ? check->until.event : EVENT_NONE;
}
