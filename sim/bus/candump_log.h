/* A log of every frame in the format of `candump -L`, which can-utils, python-can and cantools read. */
#ifndef COMANIP_SIM_CANDUMP_LOG_H
#define COMANIP_SIM_CANDUMP_LOG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "../../firmware/protocol/can_frame.h"

typedef struct candump_log candump_log_t;

/* Creates or empties the file; `path` must outlive the log. Returns NULL on failure; `error` then holds one line that
 * names the file and the cause. */
candump_log_t *candump_log_open(const char *path, char error[], size_t error_size);

/* Adds a frame. end_ns: end of the frame on the clock that stamps the log (bus_epoch_ns()). The interface is always
 * logged as vcan0. Write errors are reported by candump_log_close(). */
void candump_log_write(candump_log_t *self, const can_frame_t *frame, int64_t end_ns);

/* Closes the log and frees self. Returns false, with one line in `error`, if part of the log could not be written. */
bool candump_log_close(candump_log_t *self, char error[], size_t error_size);

#endif
