/* A bus listener that keeps simulated time from running ahead of real time. After each frame, the listener waits until
 * the wall clock reaches the frame's end time. */
#ifndef COMANIP_SIM_REAL_TIME_H
#define COMANIP_SIM_REAL_TIME_H

#include <stdint.h>
#include <time.h>

#include "bus.h"

typedef struct {
    struct timespec start; /* CLOCK_MONOTONIC at time 0 */
    int64_t latest_ns;     /* largest lateness of a frame */
} real_time_t;

void real_time_start(real_time_t *self);

/* Handler for bus_listen(). context: the real_time_t. */
void real_time_wait(void *context, const can_frame_t *frame, int64_t end_ns);

#endif
