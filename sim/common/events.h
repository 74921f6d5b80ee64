/* What has happened in a run, by name: steps of the people and of the operator done, grips made and lost. Scripts wait
 * for events, checks are measured between them, plots label them. Names are "ACTOR.WHAT", as in "person.at_spot_1". */
#ifndef COMANIP_SIM_EVENTS_H
#define COMANIP_SIM_EVENTS_H

#include <stdbool.h>
#include <stddef.h>

#define EVENT_NAME_BYTES 64
#define EVENTS_MAX 128
#define EVENT_NONE (-1)

typedef struct {
    char name[EVENT_NAME_BYTES];
    int times; /* raised so often */
    double first_s, last_s;
} event_t;

typedef struct {
    event_t event[EVENTS_MAX]; /* in the order of their declaration */
    size_t count;
} events_t;

void events_init(events_t *self);

/* "actor.what", once. Gives its number, also if it is declared already; EVENT_NONE: there are EVENTS_MAX already, or
 * the name is too long. */
int events_declare(events_t *self, const char *actor, const char *what);

/* EVENT_NONE: there is none of this name. */
int events_find(const events_t *self, const char *name);

/* EVENT_NONE is ignored. */
void events_raise(events_t *self, int event, double now_s);

bool events_happened(const events_t *self, int event);

#endif
