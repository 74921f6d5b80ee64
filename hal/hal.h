/* The whole boundary between the firmware and its platform: link-time functions, one folder per port.
 * firmware/main.c calls them from one thread. Ports themselves may call hal_panic(). */
#ifndef COMANIP_HAL_H
#define COMANIP_HAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "../firmware/protocol/can_frame.h"
#include "../firmware/protocol/can_profile.h"
#include "../firmware/protocol/port_status.h"

/* Starts clock, CAN controller (1 Mbit/s; data phase of CAN FD 5 Mbit/s) and watchdog. Panics on defective hardware. */
void hal_init(void);

/* What the bus carries: fixed by the board, or chosen by whoever starts the port. */
can_profile_t hal_can_profile(void);

/* Sleeps until the next tick of 1 kHz and gives its time, monotonic modulo 2^32 us. Missed ticks are skipped, not
 * caught up. False: the platform shuts down, as a simulation or a process does. */
bool hal_wait_tick(uint32_t *now_us);

/* The oldest frame received, with its time of reception, which may be after that of the tick. False: there is none. */
bool hal_can_receive(can_frame_t *frame);

/* Queues a frame without blocking. False: the queue is full, and the frame is dropped and counted. */
bool hal_can_send(const can_frame_t *frame);

/* Faults of the port since hal_init(): counts, and which of them it cannot know. */
void hal_port_status(port_status_t *status);

/* Once per tick. The platform takes the drives' power away if 10 ms pass without a call. */
void hal_watchdog_feed(void);

/* The drives' enable line, off after hal_init(). It permits motion and never causes any: drives move as commanded over
 * the bus. Does nothing on a port without this line. */
void hal_enable_drives(bool enable);

/* Takes the drives' power away by the shortest way, reports the cause (one line) on the console, if any, and stops for
 * good. */
_Noreturn void hal_panic(const char *cause);

/* ---- one non-volatile record, if the port has a store */

typedef enum {
    HAL_STORE_NONE, /* no store */
    HAL_STORE_WRITING,
    HAL_STORE_WRITTEN,
    HAL_STORE_FAILED, /* the previous record is kept; the cause is on the console, if any */
} hal_store_status_t;

/* The record as of hal_init(): copies up to `capacity` bytes and gives their number. False: there is none. */
bool hal_store_read(void *bytes, size_t capacity, size_t *length);

/* Starts to replace the record by a copy of these bytes, and returns at once. If interrupted, the next boot reads
 * either the previous record or this one. Not to be called during HAL_STORE_WRITING. */
void hal_store_write(const void *bytes, size_t length);

/* Of the last write. */
hal_store_status_t hal_store_status(void);

#endif
