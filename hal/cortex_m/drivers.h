/* Functions shared by the files of a port to a Cortex-M microcontroller. */
#ifndef COMANIP_CORTEX_M_DRIVERS_H
#define COMANIP_CORTEX_M_DRIVERS_H

#include <stdbool.h>
#include <stdint.h>

#include "../common/clock.h"

/* Defined in clock.c, or, for a chip without SysTick, in its port: starts the 1 kHz tick and the microsecond clock. */
void clock_start(void);

/* Defined in stack_guard.c. After this call, an overflow of the thread's stack causes a fault. */
void stack_guard_start(void);
bool stack_overflowed(void); /* for fault handlers: the thread's stack has overflowed or is about to */

/* Defined in startup.c: the handler of exceptions that must not occur. Panics. */
void unexpected_handler(void);

/* Starts the board's UART: 8N1, interrupt-driven, connected to slcan_hal_link. */
void uart_start(void);

/* Starts the board's watchdog. If it is not fed in time, it triggers a panic; if even the panic does not run, it resets
 * the board. */
void watchdog_start(uint32_t timeout_us);
void watchdog_feed(void);

#endif
