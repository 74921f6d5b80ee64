#include "reason.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "../scenario/forbidden_drop.h"

#define TICK_S (WORLD_TICK_NS * 1e-9)

__attribute__((format(printf, 2, 3))) static void append(checks_t *checks, const char *format, ...) {
    const size_t used = strlen(checks->reason);
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(checks->reason + used, sizeof checks->reason - used, format, arguments);
    va_end(arguments);
}

/* Reports dropped objects. They come first in the reason, because a drop usually causes the other failures. */
static void append_drops(checks_t *checks, const world_t *world) {
    for (size_t i = 0; i < world->scenario->object_count; i++) {
        const event_t *drop = forbidden_drop(world->scenario, &world->events, i);
        if (drop != NULL) {
            append(checks, "%s at %.2f s; ", drop->name, drop->first_s);
        }
    }
}

static void append_failed_checks(checks_t *checks, const world_t *world) {
    const check_t *first = NULL;
    size_t failed = 0;
    for (size_t i = 0; i < checks->count; i++) {
        if (!checks->check[i].pass) {
            failed++;
            first = first == NULL ? &checks->check[i] : first;
        }
    }
    const char *space = first->unit[0] != '\0' ? " " : "";
    append(checks, "%zu of %zu checks failed; first: %s ", failed, checks->count, first->name);
    if (first->measured) {
        append(checks, "is %.6g%s%s, ", first->value, space, first->unit);
    } else if (first->missing_event != NULL) {
        append(checks, "could not be measured (%s never happened), ", first->missing_event);
    } else {
        append(checks, "could not be measured, ");
    }
    append(checks, "expected at %s %.6g%s%s", first->is_lower_bound ? "least" : "most", first->limit, space,
           first->unit);
    if (world->observer.limits.first[0] != '\0') {
        append(checks, "; %s", world->observer.limits.first);
    }
}

static void append_what_is_left_out(checks_t *checks, const world_t *world) {
    if (checks->left_out_by_end > 0) {
        append(checks, "; %zu left out: they lie beyond the end of the run", checks->left_out_by_end);
    }
    if (checks->left_out_by_clutch > 0) {
        append(checks, "; %zu left out: they compare with the start of their window, but a clutch set a new reference",
               checks->left_out_by_clutch);
    }
    if (checks->left_out_by_recording > 0) {
        append(checks, "; %zu left out: they apply to the built-in motion, but a recording was played",
               checks->left_out_by_recording);
    }
    if (checks->left_out_by_define > 0) {
        append(checks, "; %zu left out: they apply to the scenario's own task, but --define replaced it",
               checks->left_out_by_define);
    }
    if (checks->left_out_by_trace > 0) {
        append(checks, "; %zu left out: they need the target, but the trace is switched off",
               checks->left_out_by_trace);
    } else if (!checks_tracking_measured(world)) {
        append(checks, "; tracking was not measured: %s",
               world->observer.parameter[PARAMETER_TRACE] > 0.0f ? "no TickTrace had a target"
                                                                 : "the trace is switched off");
    }
    if (checks->rest_not_measured[0] != '\0') {
        append(checks, "; comes_to_rest was not measured: %s", checks->rest_not_measured);
    }
    if (checks->tracking_not_judged) {
        append(checks, "; tracking was not judged: the arm could follow for %.2f s, and the check needs %g s",
               (double)world->tracking.followable.ticks * TICK_S, CHECKS_FOLLOWABLE_MIN_S);
    }
}

static void append_holds(checks_t *checks, const world_t *world) {
    const observer_t *observer = &world->observer;
    size_t holds = 0;
    double hold_s = 0.0;
    bool until_stop = false;
    for (size_t i = 0; i < observer->mode_count; i++) {
        if (observer->modes[i].mode == MODE_HOLD) {
            const bool is_last = i + 1 == observer->mode_count;
            holds++;
            hold_s += (is_last ? (double)world->now_ns * 1e-9 : observer->modes[i + 1].t_s) - observer->modes[i].t_s;
            until_stop = is_last || observer->modes[i + 1].mode != MODE_COOPERATING;
        }
    }
    if (holds > 0) {
        append(checks, "; %zu hold%s, %.2f s in total%s", holds, holds == 1 ? "" : "s", hold_s,
               until_stop ? "; cooperation did not resume after the last one" : "");
    }
}

/* Reports how long the target was out of reach. Recordings often leave the robot's reach, because a person's arm is
 * longer than this robot's. */
static void append_reach(checks_t *checks, const world_t *world) {
    const uint64_t out = world->tracking.out_of_reach_ticks, all = world->tracking.all.ticks;
    if (out == 0) {
        return;
    }
    append(checks, "; target out of reach %.2f of %.2f s, followable for %.2f of %.2f s", (double)out * TICK_S,
           (double)all * TICK_S, (double)world->tracking.followable.ticks * TICK_S, (double)all * TICK_S);
    if (2 * out <= all) {
        return;
    }
    const double scale = (double)world->observer.parameter[PARAMETER_MOTION_SCALE];
    const double minimum = (double)parameter_table[PARAMETER_MOTION_SCALE].minimum;
    const double reachable = largest_scale(&world->largest_scale, scale, minimum);
    if (reachable > 0.0 && reachable < scale) {
        append(checks, ": try --scale %g", reachable);
    }
}

void reason_write(checks_t *checks, const world_t *world) {
    checks->reason[0] = '\0';
    if (!checks->pass && *world->interrupted == 0) {
        append_drops(checks, world);
    }
    if (world->failure[0] != '\0') {
        append(checks, "%s", world->failure);
        return;
    }
    if (checks->pass) {
        append(checks, "all %zu checks passed", checks->count);
    } else {
        append_failed_checks(checks, world);
    }
    append_what_is_left_out(checks, world);
    append_holds(checks, world);
    append_reach(checks, world);
}
