#include "run_files.h"

static void log_frame(void *context, const can_frame_t *frame, int64_t end_ns) {
    const run_files_t *self = context;
    candump_log_write(self->log, frame, bus_epoch_ns(self->bus) + end_ns);
}

bool run_files_open(run_files_t *self, const world_t *world, const char *log_path, const char *trace_path, char error[],
                    size_t error_size) {
    self->bus = world->bus;
    self->log = candump_log_open(log_path, error, error_size);
    if (self->log == NULL || !trace_csv_open(&self->trace, trace_path, error, error_size)) {
        return false;
    }
    bus_listen(world->bus, log_frame, self);
    return true;
}

void run_files_write_tick(run_files_t *self, const world_t *world) {
    trace_csv_write(&self->trace, &world->observer.tick, &world->state);
}

bool run_files_close(run_files_t *self, const char *trace_path, char error[], size_t error_size) {
    const bool trace_closed = trace_csv_close(&self->trace, trace_path, error, error_size);
    return candump_log_close(self->log, error, error_size) && trace_closed;
}
