/* Named events of a run: steps that the people or the operator have finished, and grips made or lost. Scripts wait for
 * events, checks are measured between events, and plots are labelled with them. A name is "ACTOR.WHAT", for example
 * "person.at_spot_1". */
#ifndef COMANIP_SIM_EVENTS_H
#define COMANIP_SIM_EVENTS_H

#include <stdbool.h>
#include <stddef.h>

#define EVENT_NAME_BYTES 64
#define EVENTS_MAX 128
#define EVENT_NONE (-1)

typedef struct {
    char name[EVENT_NAME_BYTES];
    int times; /* how often the event was raised */
    double first_s, last_s;
} event_t;

typedef struct {
    event_t event[EVENTS_MAX]; /* in order of declaration */
    size_t count;
} events_t;

void events_init(events_t *self);

/* Declares the event "actor.what" and returns its index. Declaring it again returns the same index. Returns EVENT_NONE
 * if there are already EVENTS_MAX events or the name is too long. */
int events_declare(events_t *self, const char *actor, const char *what);

/* Returns the index of the event, or EVENT_NONE if no event has this name. */
int events_find(const events_t *self, const char *name);

/* Records that the event happened at now_s. EVENT_NONE is ignored. */
void events_raise(events_t *self, int event, double now_s);

bool events_happened(const events_t *self, int event);

#endif
