/* What a port to a Cortex-M microcontroller has, among its files. */
#ifndef COMANIP_CORTEX_M_DRIVERS_H
#define COMANIP_CORTEX_M_DRIVERS_H

#include <stdbool.h>
#include <stdint.h>

#include "../common/clock.h"

/* clock.c, or the board's own where there is no SysTick: the 1 kHz tick and the microsecond clock. */
void clock_start(void);

/* stack_guard.c: from here on the thread's stack faults when it overflows. */
void stack_guard_start(void);
bool stack_overflowed(void); /* in a handler: whether the thread left its stack, or as good as that */

/* startup.c: for an exception that the board does not have. */
void unexpected_handler(void);

/* The board's, 8N1, interrupt-driven, into slcan_hal_link. */
void uart_start(void);

/* The board's: panics when not fed for the time; resets if even that does not stop it. */
void watchdog_start(uint32_t timeout_us);
void watchdog_feed(void);

#endif
