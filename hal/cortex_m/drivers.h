/* The port's drivers among themselves. */
#ifndef COMANIP_CORTEX_M_DRIVERS_H
#define COMANIP_CORTEX_M_DRIVERS_H

#include <stdint.h>

/* clock.c: SysTick as the 1 kHz tick and the microsecond clock. */
void clock_start(void);
uint32_t clock_us(void);             /* monotonic modulo 2^32; also in interrupts */
void systick_handler(void);

/* cmsdk_uart.c: 8N1, interrupt-driven, into slcan_hal_link. */
void uart_start(void);
void uart_rx_handler(void);
void uart_tx_handler(void);

/* cmsdk_watchdog.c: NMI when not fed for the time, reset when the NMI does not stop it. */
void watchdog_start(uint32_t timeout_us);
void watchdog_feed(void);
void watchdog_stop(void);

#endif
