/* The files that a run fills as it goes on: bus.log and trace.csv. */
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

/* From here on the log gets every frame of the world's bus. Must not move. On failure false, and one line in `error`.
 */
bool run_files_open(run_files_t *self, const world_t *world, const char *log_path, const char *trace_path, char error[],
                    size_t error_size);

/* Adds the tick to the trace. Call it after each one. */
void run_files_write_tick(run_files_t *self, const world_t *world);

/* False, and one line in `error`, if not everything reached the files. */
bool run_files_close(run_files_t *self, const char *trace_path, char error[], size_t error_size);

#endif
