/* For ports with a UART instead of a CAN controller. Such a port provides the functions so marked below. In return,
 * slcan_hal.c implements hal_can_send() for it, and slcan_receive.c implements hal_can_receive() and
 * hal_port_status(). */
#ifndef COMANIP_SLCAN_HAL_H
#define COMANIP_SLCAN_HAL_H

#include "slcan_link.h"

/* The only link. The UART's interrupt handler feeds and drains it. */
extern slcan_link_t slcan_hal_link;

/* Provided by the port: makes the transmit interrupt take the bytes that are waiting in the link. */
void serial_start_transmission(void);

/* Provided by the port: sleeps until the next interrupt, at the latest that of the tick. */
void serial_wait(void);

/* Provided by the port, for hal/lockstep: returns the last argument of hal_enable_drives(). */
bool drives_enabled(void);

/* Provided by the port: sends one byte by polling, with interrupts off. */
void serial_write_polled(uint8_t byte);

/* For hal_panic(), with interrupts off: ends the current line and sends "#panic: CAUSE", which no SLCAN reader mistakes
 * for a frame. */
void slcan_hal_report_panic(const char *cause);

#endif
