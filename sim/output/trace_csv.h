/* trace.csv: one line per tick with target, ODE's hand, each joint's measured position and commanded velocity, and the
 * scene: people's hands, the object, forces, clearances, water. */
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

/* On failure false, and one line in `error`. */
bool trace_csv_open(trace_csv_t *self, const char *path, char error[], size_t error_size);

/* Record and state are of one instant. Columns without a value stay empty: no target or command in this tick; no second
 * person, object, water or crank in this scenario. */
void trace_csv_write(trace_csv_t *self, const tick_record_t *tick, const physical_state_t *state);

/* False, and one line in `error`, if not everything reached the file. */
bool trace_csv_close(trace_csv_t *self, const char *path, char error[], size_t error_size);

#endif
