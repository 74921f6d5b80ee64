/* The schedule of a 1 kHz loop against the wall clock, in absolute time (CLOCK_MONOTONIC).
 *
 * The loop's clock is Unix time divided by the time scale, so that a frame's time in a log of the same bus (candump, or
 * the plant's own) is, modulo 2^32 us, the time that the firmware had for it: logs can be replayed. Ticks lie on whole
 * milliseconds of that clock. When the system's clock is set, the loop's own goes on, and the step is taken out of the
 * kernel's time stamps. */
#ifndef COMANIP_PACE_H
#define COMANIP_PACE_H

#include <stdbool.h>
#include <stdint.h>

#define PACE_TICK_NS INT64_C(1000000) /* by the loop's clock */
#define PACE_SLOW_MAX 1000u

typedef struct {
    int64_t slow;       /* ns of wall time in one of the loop's clock: 1..PACE_SLOW_MAX */
    int64_t offset_ns;  /* Unix time less CLOCK_MONOTONIC, at the start */
    int64_t step_ns;    /* by which the system's clock has been set since */
    int64_t tick_ns;    /* Unix time of the last tick, a multiple of the tick's length */
    uint64_t overruns;  /* ticks that were left out since the loop was late */
    bool in_tick;       /* one was given, and the loop has not waited for the next */
    int64_t longest_ns; /* from a tick to the next wait, by the loop's clock, at most */
} pace_t;

void pace_init(pace_t *self, uint32_t slow);

/* Sleeps until the next tick; those that have passed meanwhile are left out and counted. False: a signal came. */
bool pace_wait_tick(pace_t *self);

/* Wall time now, by the clock of the start. */
int64_t pace_now_unix_ns(const pace_t *self);

/* A kernel time stamp, by the clock of the start. */
int64_t pace_stamp_unix_ns(const pace_t *self, int64_t stamp_unix_ns);

/* True, once each time: the system's clock was set. */
bool pace_find_step(pace_t *self);

/* What the loop's clock shows then, modulo 2^32. */
uint32_t pace_clock_us(const pace_t *self, int64_t unix_ns);

/* Asks for SCHED_FIFO at this priority and for locked memory. Tells on stdout what was granted, in one line. */
void pace_make_real_time(const char *program, int priority);

#endif
