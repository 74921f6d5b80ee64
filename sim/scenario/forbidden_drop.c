#include "forbidden_drop.h"

#include <stdio.h>

static bool is_forbidden(const scenario_t *scenario, size_t object, int times) {
    for (size_t i = 0; i < scenario->check_count; i++) {
        const scenario_check_t *check = &scenario->check[i];
        if (check->measure == MEASURE_DROPS && check->object == object && !check->is_lower_bound &&
            times > check->limit) {
            return true;
        }
    }
    return false;
}

const event_t *forbidden_drop(const scenario_t *scenario, const events_t *events, size_t object) {
    char name[SCENARIO_NAME_BYTES + sizeof ".dropped"];
    (void)snprintf(name, sizeof name, "%s.dropped", scenario->object[object].name);
    const int number = events_find(events, name);
    const bool has_dropped = events_happened(events, number);
    return has_dropped && is_forbidden(scenario, object, events->event[number].times) ? &events->event[number] : NULL;
}
