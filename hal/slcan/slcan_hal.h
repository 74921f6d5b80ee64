/* For ports with a UART instead of a CAN controller. Such a port defines the functions that are marked "Provided by
 * the port" below. With them, slcan_hal.c defines hal_can_send() for the port, and slcan_receive.c defines
 * hal_can_receive() and hal_port_status(). */
#ifndef COMANIP_SLCAN_HAL_H
#define COMANIP_SLCAN_HAL_H

#include "slcan_link.h"

/* The port's only link. The UART's interrupt handler writes received bytes to the link and reads bytes to send from the
 * link. */
extern slcan_link_t slcan_hal_link;

/* Provided by the port: makes the transmit interrupt take the bytes that are waiting in the link. */
void serial_start_transmission(void);

/* Provided by the port: sleeps until the next interrupt, which is the tick's at the latest. */
void serial_wait(void);

/* Provided by the port, for hal/lockstep: returns the value last passed to hal_enable_drives(). */
bool drives_enabled(void);

/* Provided by the port: sends one byte by polling, with interrupts off. */
void serial_write_polled(uint8_t byte);

/* For hal_panic(), with interrupts off: ends the current line and sends "#panic: CAUSE", which no SLCAN reader mistakes
 * for a frame. */
void slcan_hal_report_panic(const char *cause);

#endif
