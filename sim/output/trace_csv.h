/* Writes trace.csv: one line per tick with the target, the end effector in ODE, each joint's measured position and
 * commanded velocity, and the scene (hands of the people, object, forces, clearances, water and crank). */
#ifndef COMANIP_SIM_TRACE_CSV_H
#define COMANIP_SIM_TRACE_CSV_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "../monitors/observer.h"
#include "../monitors/physical_state.h"

typedef struct {
    FILE *file;
} trace_csv_t;

/* Returns false on failure, with one line in `error`. */
bool trace_csv_open(trace_csv_t *self, const char *path, char error[], size_t error_size);

/* Writes one line. tick and state must belong to the same instant. Columns without a value stay empty, for example if
 * the tick has no target or the scenario has no second person. */
void trace_csv_write(trace_csv_t *self, const tick_record_t *tick, const physical_state_t *state);

/* Closes the file. Returns false, with one line in `error`, if it is incomplete. */
bool trace_csv_close(trace_csv_t *self, const char *path, char error[], size_t error_size);

#endif
