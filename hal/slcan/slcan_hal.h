/* For ports with a UART instead of a CAN controller. A port provides the functions below, and gets hal_can_send()
 * (slcan_hal.c), hal_can_receive() and hal_port_status() (slcan_receive.c). */
#ifndef COMANIP_SLCAN_HAL_H
#define COMANIP_SLCAN_HAL_H

#include "slcan_link.h"

/* The one link; the UART's interrupt handler feeds and drains it. */
extern slcan_link_t slcan_hal_link;

/* Provided by the port: makes the transmit interrupt take the bytes that wait in the link. */
void serial_start_transmission(void);

/* Provided by the port: sleeps until an interrupt, a tick's at the latest. */
void serial_wait(void);

/* Provided by the port, for hal/lockstep: the last argument of hal_enable_drives(). */
bool drives_enabled(void);

/* Provided by the port: sends one byte by polling, interrupts off. */
void serial_write_polled(uint8_t byte);

/* For hal_panic(), interrupts off: ends the current line and sends "#panic: CAUSE", which no SLCAN reader takes for a
 * frame. */
void slcan_hal_report_panic(const char *cause);

#endif
