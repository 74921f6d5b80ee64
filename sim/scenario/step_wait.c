#include "step_wait.h"

#include <math.h>
#include <stdio.h>

bool step_wait_begin_s(const step_start_t *start, const events_t *events, double ready_s, double *begin_s) {
    const bool waits = start->awaited_count > 0; /* if false, the delay counts from the end of the previous step */
    *begin_s = fmax(start->at_s, waits ? ready_s : ready_s + start->delay_s);
    for (size_t i = 0; i < start->awaited_count; i++) {
        if (!events_happened(events, start->awaited[i])) {
            return false;
        }
        *begin_s = fmax(*begin_s, events->event[start->awaited[i]].first_s + start->delay_s);
    }
    return true;
}

const char *step_wait_missing(const step_start_t *start, const events_t *events) {
    for (size_t i = 0; i < start->awaited_count; i++) {
        if (!events_happened(events, start->awaited[i])) {
            return events->event[start->awaited[i]].name;
        }
    }
    return NULL;
}

bool step_wait_timed_out(const step_start_t *start, const events_t *events, double ready_s, double now_s, char text[],
                         size_t size) {
    const double since_s = fmax(ready_s, start->at_s);
    if (start->patience_s <= 0.0 || now_s - since_s <= start->patience_s) {
        return false;
    }
    const char *missing = step_wait_missing(start, events);
    if (missing != NULL) {
        (void)snprintf(text, size, "timed out after %g s waiting for %s", start->patience_s, missing);
    }
    return missing != NULL;
}
