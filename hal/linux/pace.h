/* The schedule of a 1 kHz loop against the wall clock, in absolute time (CLOCK_MONOTONIC).
 *
 * The loop's clock is Unix time divided by the time scale. A frame's time in a log of the same bus (candump, or the
 * plant's own) is therefore, modulo 2^32 us, the time that the firmware used, and logs can be replayed. Ticks are at
 * whole milliseconds of that clock. If the system's clock is set, the loop's clock continues, and the step is
 * subtracted from the kernel's time stamps. */
#ifndef COMANIP_PACE_H
#define COMANIP_PACE_H

#include <stdbool.h>
#include <stdint.h>

#define PACE_TICK_NS INT64_C(1000000) /* on the loop's clock */
#define PACE_SLOW_MAX 1000u

typedef struct {
    int64_t slow;       /* ns of wall time per ns of the loop's clock: 1..PACE_SLOW_MAX */
    int64_t offset_ns;  /* Unix time minus CLOCK_MONOTONIC, at the start */
    int64_t step_ns;    /* by which the system's clock has been set since */
    int64_t tick_ns;    /* Unix time of the last tick, a multiple of the tick's length */
    uint64_t overruns;  /* ticks skipped because the loop was late */
    bool in_tick;       /* the loop is between a tick and the wait for the next */
    int64_t longest_ns; /* maximum from a tick to the next wait, on the loop's clock */
} pace_t;

void pace_init(pace_t *self, uint32_t slow);

/* Sleeps until the next tick; missed ticks are skipped and counted. False: a signal came. */
bool pace_wait_tick(pace_t *self);

/* Wall time now, on the clock as of the start. */
int64_t pace_now_unix_ns(const pace_t *self);

/* A kernel time stamp, on the clock as of the start. */
int64_t pace_stamp_unix_ns(const pace_t *self, int64_t stamp_unix_ns);

/* True, once each time that the system's clock was set. */
bool pace_find_step(pace_t *self);

/* The loop's clock at this Unix time, modulo 2^32. */
uint32_t pace_clock_us(const pace_t *self, int64_t unix_ns);

/* Asks for SCHED_FIFO at this priority and for locked memory. Reports on stdout, in one line, which were granted. */
void pace_make_real_time(const char *program, int priority);

#endif
