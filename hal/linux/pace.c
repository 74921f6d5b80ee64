#include "pace.h"

#include <errno.h>
#include <sched.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>

#define NS_PER_S INT64_C(1000000000)
#define STEP_MIN_NS INT64_C(1000000) /* successive readings of two clocks differ by a few us */

static int64_t read_ns(clockid_t clock) {
    struct timespec now;
    (void)clock_gettime(clock, &now);
    return (int64_t)now.tv_sec * NS_PER_S + now.tv_nsec;
}

static int64_t period_ns(const pace_t *self) {
    return self->slow * PACE_TICK_NS;
}

void pace_init(pace_t *self, uint32_t slow) {
    *self = (pace_t){.slow = slow, .offset_ns = read_ns(CLOCK_REALTIME) - read_ns(CLOCK_MONOTONIC)};
    self->tick_ns = pace_now_unix_ns(self) / period_ns(self) * period_ns(self);
}

static void end_tick(pace_t *self) {
    const int64_t spent_ns = (pace_now_unix_ns(self) - self->tick_ns) / self->slow;
    if (self->in_tick && spent_ns > self->longest_ns) {
        self->longest_ns = spent_ns;
    }
    self->in_tick = false;
}

bool pace_wait_tick(pace_t *self) {
    end_tick(self);
    const int64_t next_ns = self->tick_ns + period_ns(self);
    const int64_t wake_ns = next_ns - self->offset_ns;
    const struct timespec wake = {.tv_sec = (time_t)(wake_ns / NS_PER_S), .tv_nsec = (long)(wake_ns % NS_PER_S)};
    if (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, NULL) != 0) {
        return false;
    }
    const int64_t late = (pace_now_unix_ns(self) - next_ns) / period_ns(self);
    self->overruns += (uint64_t)late;
    self->tick_ns = next_ns + late * period_ns(self);
    self->in_tick = true;
    return true;
}

int64_t pace_now_unix_ns(const pace_t *self) {
    return read_ns(CLOCK_MONOTONIC) + self->offset_ns;
}

int64_t pace_stamp_unix_ns(const pace_t *self, int64_t stamp_unix_ns) {
    return stamp_unix_ns - self->step_ns;
}

bool pace_find_step(pace_t *self) {
    const int64_t before_ns = read_ns(CLOCK_MONOTONIC);
    const int64_t unix_ns = read_ns(CLOCK_REALTIME);
    const int64_t after_ns = read_ns(CLOCK_MONOTONIC);
    const int64_t step_ns = unix_ns - before_ns - self->offset_ns;
    const int64_t change_ns = step_ns - self->step_ns;
    const int64_t doubt_ns = after_ns - before_ns; /* the process may have been paused between the readings */
    if (change_ns > -STEP_MIN_NS && change_ns < STEP_MIN_NS + doubt_ns) {
        return false;
    }
    self->step_ns = step_ns;
    return true;
}

uint32_t pace_clock_us(const pace_t *self, int64_t unix_ns) {
    return (uint32_t)(unix_ns / (1000 * self->slow));
}

void pace_make_real_time(const char *program, int priority) {
    const struct sched_param parameters = {.sched_priority = priority};
    const int fifo_error = sched_setscheduler(0, SCHED_FIFO, &parameters) == 0 ? 0 : errno;
    const int lock_error = mlockall(MCL_CURRENT | MCL_FUTURE) == 0 ? 0 : errno;
    if (fifo_error == 0 && lock_error == 0) {
        (void)printf("%s: real-time priority %d, memory locked\n", program, priority);
    } else {
        (void)printf("%s: not real-time: %s%s%s%s%s; missed ticks are counted (limits: ulimit -r, ulimit -l)\n",
                     program, fifo_error != 0 ? "SCHED_FIFO: " : "", fifo_error != 0 ? strerror(fifo_error) : "",
                     fifo_error != 0 && lock_error != 0 ? ", " : "", lock_error != 0 ? "locked memory: " : "",
                     lock_error != 0 ? strerror(lock_error) : "");
    }
    (void)fflush(stdout);
}
