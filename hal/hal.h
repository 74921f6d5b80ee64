/* The whole boundary between the firmware and its platform: link-time functions, one folder per port.
 * Called from firmware/main.c alone, from one thread. */
#ifndef COMANIP_HAL_H
#define COMANIP_HAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "../firmware/protocol/can_frame.h"
#include "../firmware/protocol/can_profile.h"

/* Clock, CAN controller (1 Mbit/s, FD's data phase 5 Mbit/s), watchdog. Panics if the hardware does not answer. */
void hal_init(void);

/* What the bus carries: a property of the board, or chosen by whoever starts the port. */
can_profile_t hal_can_profile(void);

/* Sleeps until the next 1 kHz tick and gives its time, monotonic modulo 2^32 us. False when the platform shuts down,
 * as a simulation or a process does. A tick that was missed is not made up for. */
bool hal_wait_tick(uint32_t *now_us);

/* Next received frame, oldest first, with its time of reception, which may be after that of the tick. False: none left.
 */
bool hal_can_receive(can_frame_t *frame);

/* Queues a frame, CAN FD or classic as it says. False: the queue is full and the frame is dropped (the port counts it).
 * Never blocks. */
bool hal_can_send(const can_frame_t *frame);

/* Once per tick. The platform stops the drives if it is not called for 10 ms. */
void hal_watchdog_feed(void);

/* ---- one record that outlasts a loss of power, if the port has a store for it */

typedef enum {
    HAL_STORE_NONE, /* this port has no store */
    HAL_STORE_WRITING,
    HAL_STORE_WRITTEN,
    HAL_STORE_FAILED, /* the former record is still there; the port has said why on whatever console there is */
} hal_store_status_t;

/* The record as it was at hal_init(), up to `capacity` bytes of it, and how many these are. False: there is none. */
bool hal_store_read(void *bytes, size_t capacity, size_t *length);

/* Begins to write another record in its place, from a copy, and returns at once: flash and disks take longer than a
 * tick. Whatever interrupts it, the next boot reads the former record or this one. Not while one is HAL_STORE_WRITING.
 */
void hal_store_write(const void *bytes, size_t length);

/* Of the last write. */
hal_store_status_t hal_store_status(void);

/* The line by which the drives have power, off after hal_init(). Allows motion, and never causes any: what moves is
 * commanded over the bus. A port without such a line does nothing here. */
void hal_enable_drives(bool enable);

/* Takes the drives' power away by the shortest way the platform has, says why on whatever console there is, and never
 * returns. cause: one line. */
_Noreturn void hal_panic(const char *cause);

#endif
