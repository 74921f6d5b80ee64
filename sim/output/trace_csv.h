/* trace.csv: one line per tick with target, ODE's hand, and each joint's measured position and commanded velocity. */
#ifndef COMANIP_SIM_TRACE_CSV_H
#define COMANIP_SIM_TRACE_CSV_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "../monitors/observer.h"

typedef struct {
    FILE *file;
} trace_csv_t;

/* On failure false, and one line in `error`. */
bool trace_csv_open(trace_csv_t *self, const char *path, char error[], size_t error_size);

/* Columns without a value (no target, no command in this tick) stay empty. */
void trace_csv_write(trace_csv_t *self, const tick_record_t *tick);

/* False, and one line in `error`, if not everything reached the file. */
bool trace_csv_close(trace_csv_t *self, const char *path, char error[], size_t error_size);

#endif
