/* A thread that notices when the firmware's loop no longer comes round.
 *
 * What it can do on Linux: end the process, for good, with the cause on stderr. The commands have ended by themselves,
 * the drives brake on their own after 3 ms without one; what is prevented is a loop that comes back to life by itself.
 * It counts its own looks at the loop, not time, so that a process that was paused as a whole is not taken for a loop
 * that hangs: then the firmware itself finds its inputs stale, and says so on the bus. */
#ifndef COMANIP_LINUX_WATCHDOG_H
#define COMANIP_LINUX_WATCHDOG_H

#include <stdint.h>

/* Looks every look_ns of wall time; after 10 looks in a row without a feed it calls hal_panic(). Starts with the first
 * feed. priority: of SCHED_FIFO, above that of the loop, which may hang in a circle. Panics if there is no thread to be
 * had. */
void watchdog_start(int64_t look_ns, int priority);

void watchdog_feed(void);

#endif
