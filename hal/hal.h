/* The complete interface between the firmware and its platform. Each port implements the functions in its own folder,
 * and the firmware is linked with one port. Only firmware/main.c calls the functions, from a single thread; hal_panic()
 * may also be called by the port itself. */
#ifndef COMANIP_HAL_H
#define COMANIP_HAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "../firmware/protocol/can_frame.h"
#include "../firmware/protocol/can_profile.h"
#include "../firmware/protocol/port_status.h"

/* Starts the clock, the CAN controller (1 Mbit/s; data phase of CAN FD 5 Mbit/s) and the watchdog. Panics if the
 * hardware is defective. */
void hal_init(void);

/* Returns the kind of CAN bus (CAN FD or classic). The board, a button or a command-line option determines it. */
can_profile_t hal_can_profile(void);

/* Sleeps until the next 1 kHz tick and returns the tick's time in *now_us, monotonic modulo 2^32 us. Missed ticks
 * are skipped, not made up for. Returns false if the platform is shutting down, which happens only in a simulation or
 * in a Linux process. */
bool hal_wait_tick(uint32_t *now_us);

/* Returns the oldest received frame, with its time of reception, which may be later than the tick's time. Returns false
 * if there is none. */
bool hal_can_receive(can_frame_t *frame);

/* Queues a frame without blocking. If the queue is full, drops and counts the frame, and returns false. */
bool hal_can_send(const can_frame_t *frame);

/* Reports the port's fault counts since hal_init(), and marks those that the port cannot know. */
void hal_port_status(port_status_t *status);

/* Must be called once per tick. If it is not called for 10 ms, the port panics: see hal_panic(). */
void hal_watchdog_feed(void);

/* Sets the drives' enable line, which is off after hal_init(). The line permits motion but never causes any, since the
 * drives move only as commanded over the bus. Does nothing on a port without this line. */
void hal_enable_drives(bool enable);

/* Cuts the drives' power in the quickest way available, reports the cause (one line) on the console, if there is one,
 * and stops for good. */
_Noreturn void hal_panic(const char *cause);

/* ---- one non-volatile record, if the port has a store */

typedef enum {
    HAL_STORE_NONE, /* no store */
    HAL_STORE_WRITING,
    HAL_STORE_WRITTEN,
    HAL_STORE_FAILED, /* the store still holds a valid record, in most cases the previous one: see hal_store_write() */
} hal_store_status_t;

/* Reads the record as it was at hal_init(): copies up to `capacity` bytes of it and returns their number in *length.
 * Returns false if there is no record. */
bool hal_store_read(void *bytes, size_t capacity, size_t *length);

/* Starts replacing the record by a copy of these bytes, and returns at once. If the write fails or is interrupted, the
 * next boot reads either the previous record or this one, never a mixture. A port with a console reports the cause of a
 * failed write there. Must not be called during HAL_STORE_WRITING. */
void hal_store_write(const void *bytes, size_t length);

/* Returns the status of the last write. */
hal_store_status_t hal_store_status(void);

#endif
