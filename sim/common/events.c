#include "events.h"

#include <stdio.h>
#include <string.h>

void events_init(events_t *self) {
    self->count = 0;
}

int events_declare(events_t *self, const char *actor, const char *what) {
    char name[EVENT_NAME_BYTES];
    const int length = snprintf(name, sizeof name, "%s.%s", actor, what);
    if (length < 0 || (size_t)length >= sizeof name) {
        return EVENT_NONE;
    }
    const int known = events_find(self, name);
    if (known != EVENT_NONE || self->count == EVENTS_MAX) {
        return known;
    }
    event_t *event = &self->event[self->count];
    *event = (event_t){.times = 0};
    memcpy(event->name, name, sizeof name);
    return (int)self->count++;
}

int events_find(const events_t *self, const char *name) {
    for (size_t i = 0; i < self->count; i++) {
        if (strcmp(self->event[i].name, name) == 0) {
            return (int)i;
        }
    }
    return EVENT_NONE;
}

void events_raise(events_t *self, int event, double now_s) {
    if (event == EVENT_NONE) {
        return;
    }
    event_t *raised = &self->event[event];
    if (raised->times == 0) {
        raised->first_s = now_s;
    }
    raised->last_s = now_s;
    raised->times++;
}

bool events_happened(const events_t *self, int event) {
    return event != EVENT_NONE && self->event[event].times > 0;
}
