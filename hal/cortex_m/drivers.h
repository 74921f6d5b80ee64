/* Functions that the files of a port to a Cortex-M microcontroller share. */
#ifndef COMANIP_CORTEX_M_DRIVERS_H
#define COMANIP_CORTEX_M_DRIVERS_H

#include <stdbool.h>
#include <stdint.h>

#include "../common/clock.h"

/* clock.c, or the board's own file if it has no SysTick: the 1 kHz tick and the microsecond clock. */
void clock_start(void);

/* stack_guard.c: from this call on an overflow of the thread's stack causes a fault. */
void stack_guard_start(void);
bool stack_overflowed(void); /* in a handler: the thread has overflowed its stack, or is about to */

/* startup.c: for exceptions that the board does not have. */
void unexpected_handler(void);

/* The board's UART: 8N1, interrupt-driven, connected to slcan_hal_link. */
void uart_start(void);

/* The board's watchdog: panics if it is not fed in time; resets the board if the panic does not stop it. */
void watchdog_start(uint32_t timeout_us);
void watchdog_feed(void);

#endif
