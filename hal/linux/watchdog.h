/* A thread that detects a hang of the firmware's loop.
 *
 * If the loop hangs, the thread ends the process, with the cause on stderr. By then the commands have already stopped,
 * and the drives have braked on their own after 3 ms without a command; the watchdog prevents the loop from resuming by
 * itself. It counts its own checks of the loop rather than time, so that pausing the whole process is not mistaken for
 * a hang. After such a pause, the firmware finds its inputs stale and reports this on the bus. */
#ifndef COMANIP_LINUX_WATCHDOG_H
#define COMANIP_LINUX_WATCHDOG_H

#include <stdint.h>

/* Checks the loop every look_ns of wall time, and calls hal_panic() after 10 consecutive checks without a feed. The
 * checks start with the first feed. priority: SCHED_FIFO priority, above that of the firmware's loop, so that the
 * checks continue if that loop hangs without sleeping. Panics if the thread cannot be created. */
void watchdog_start(int64_t look_ns, int priority);

void watchdog_feed(void);

#endif
