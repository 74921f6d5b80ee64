/* A thread that detects when the firmware's loop hangs.
 *
 * It then ends the process, with the cause on stderr. The commands have already ended, and the drives brake by
 * themselves after 3 ms without one; the watchdog prevents that the loop resumes by itself. It counts its own checks of
 * the loop, not time, so that a process that was paused as a whole is not taken for a loop that hangs: in that case the
 * firmware finds its inputs stale, and reports it on the bus. */
#ifndef COMANIP_LINUX_WATCHDOG_H
#define COMANIP_LINUX_WATCHDOG_H

#include <stdint.h>

/* Checks every look_ns of wall time; after 10 checks in a row without a feed it calls hal_panic(). Starts with the
 * first feed. priority: of SCHED_FIFO, above that of the loop, which may hang busily. Panics if no thread can be
 * created. */
void watchdog_start(int64_t look_ns, int priority);

void watchdog_feed(void);

#endif
