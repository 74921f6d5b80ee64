/* The whole boundary between the firmware and its platform: link-time functions, one folder per port.
 * Called from firmware/main.c alone, from one thread. */
#ifndef COMANIP_HAL_H
#define COMANIP_HAL_H

#include <stdbool.h>
#include <stdint.h>

#include "../firmware/can_frame.h"
#include "../firmware/can_profile.h"

/* Clock, CAN controller (1 Mbit/s, FD's data phase 5 Mbit/s), watchdog. Panics if the hardware does not answer. */
void hal_init(void);

/* What the bus carries: a property of the board, or chosen by whoever starts the port. */
can_profile_t hal_can_profile(void);

/* Sleeps until the next 1 kHz tick and gives its time, monotonic modulo 2^32 us. False when the platform shuts down,
 * as a simulation or a process does. A tick that was missed is not made up for. */
bool hal_wait_tick(uint32_t *now_us);

/* Next received frame, oldest first, with its time of reception, which may be after that of the tick. False: none left. */
bool hal_can_receive(can_frame_t *frame);

/* Queues a frame, CAN FD or classic as it says. False: the queue is full and the frame is dropped (the port counts it). Never blocks. */
bool hal_can_send(const can_frame_t *frame);

/* Once per tick. The platform stops the drives if it is not called for 10 ms. */
void hal_watchdog_feed(void);

/* Takes the drives' power away by the shortest way the platform has, says why on whatever console there is, and never
 * returns. cause: one line. */
_Noreturn void hal_panic(const char *cause);

#endif
