/* Functions shared by the port's files. */
#ifndef COMANIP_RISCV_DRIVERS_H
#define COMANIP_RISCV_DRIVERS_H

#include <stdint.h>

#include "../common/clock.h"

/* Defined in clock.c: the CLINT's machine timer as the 1 kHz tick and the microsecond clock. */
void clock_start(void);
void clock_handler(void);

/* Defined in ns16550.c: the UART, 8N1, interrupt-driven, connected to slcan_hal_link. */
void uart_start(void);
void uart_handler(void);

/* Defined in plic.c: the platform's interrupt controller, whose only source is the UART. */
void plic_start(void);
void plic_handler(void);

/* Defined in port.c: panics if the firmware has not fed the watchdog in time. Called by the tick's interrupt. */
void watchdog_check(void);

/* Defined in trap.c. Called by startup.S, on a separate stack for traps. cause: value of mcause. thread_stack: stack
 * pointer of the interrupted thread. */
void trap_handler(uint32_t cause, uintptr_t thread_stack);

#endif
