/* The files that are written during a run: bus.log and trace.csv. */
#ifndef COMANIP_SIM_RUN_FILES_H
#define COMANIP_SIM_RUN_FILES_H

#include "../bus/candump_log.h"
#include "../world/world.h"
#include "trace_csv.h"

typedef struct {
    const bus_t *bus;
    candump_log_t *log;
    trace_csv_t trace;
} run_files_t;

/* Opens the files. From then on, the log records every frame of the world's bus. self must not be moved afterwards.
 * Returns false on failure, with one line in `error`. */
bool run_files_open(run_files_t *self, const world_t *world, const char *log_path, const char *trace_path, char error[],
                    size_t error_size);

/* Adds the tick that has just been simulated to the trace. Called after each tick. */
void run_files_write_tick(run_files_t *self, const world_t *world);

/* Closes the files. Returns false, with one line in `error`, if one of them is incomplete. */
bool run_files_close(run_files_t *self, const char *trace_path, char error[], size_t error_size);

#endif
