#include "real_time.h"

#define NS_PER_S 1000000000

void real_time_start(real_time_t *self) {
    self->latest_ns = 0;
    (void)clock_gettime(CLOCK_MONOTONIC, &self->start);
}

void real_time_wait(void *context, const can_frame_t *frame, int64_t end_ns) {
    (void)frame;
    real_time_t *self = context;
    struct timespec now;
    const int64_t due_ns = self->start.tv_nsec + end_ns;
    const struct timespec due = {.tv_sec = self->start.tv_sec + due_ns / NS_PER_S, .tv_nsec = due_ns % NS_PER_S};
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    const int64_t late_ns = (now.tv_sec - due.tv_sec) * NS_PER_S + (now.tv_nsec - due.tv_nsec);
    if (late_ns < 0) {
        (void)clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, NULL); /* a signal ends the wait and then the run */
    } else if (late_ns > self->latest_ns) {
        self->latest_ns = late_ns;
    }
}
