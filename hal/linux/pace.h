/* The schedule of a 1 kHz loop against the wall clock, in absolute time (CLOCK_MONOTONIC).
 *
 * The loop's clock is Unix time divided by the time scale, so that logs can show the same times as the firmware uses
 * (modulo 2^32 us): the plant's log always does, and a log of candump does if the time scale is 1. Ticks occur at whole
 * milliseconds of the loop's clock. If the system's clock is set, the loop's clock continues unchanged, and the step is
 * subtracted from the kernel's timestamps. */
#ifndef COMANIP_PACE_H
#define COMANIP_PACE_H

#include <stdbool.h>
#include <stdint.h>

#define PACE_TICK_NS INT64_C(1000000) /* by the loop's clock */
#define PACE_SLOW_MAX 1000u

typedef struct {
    int64_t slow;       /* time scale, ns of wall time per ns of the loop's clock: 1..PACE_SLOW_MAX */
    int64_t offset_ns;  /* Unix time minus CLOCK_MONOTONIC, at the start */
    int64_t step_ns;    /* total by which the system's clock has been set since the start */
    int64_t tick_ns;    /* Unix time of the last tick, a multiple of the tick's length */
    uint64_t overruns;  /* ticks skipped because the loop was late */
    bool in_tick;       /* the loop is between a tick and the wait for the next */
    int64_t longest_ns; /* longest time from a tick to the following wait, by the loop's clock */
} pace_t;

void pace_init(pace_t *self, uint32_t slow);

/* Sleeps until the next tick; skips and counts missed ticks. Returns false if a signal ended the sleep early. */
bool pace_wait_tick(pace_t *self);

/* Returns the current wall time, ignoring any steps of the system clock since the start. */
int64_t pace_now_unix_ns(const pace_t *self);

/* Corrects a kernel timestamp for any steps of the system clock since the start, and returns it. */
int64_t pace_stamp_unix_ns(const pace_t *self, int64_t stamp_unix_ns);

/* Returns true once after each step of the system clock. */
bool pace_find_step(pace_t *self);

/* Returns the loop's clock at this Unix time, modulo 2^32. */
uint32_t pace_clock_us(const pace_t *self, int64_t unix_ns);

/* Requests SCHED_FIFO at this priority and locked memory. Reports on stdout, in one line, which of them were
 * granted. */
void pace_make_real_time(const char *program, int priority);

#endif
