/* The bus that the simulated nodes share. bus.c: a CAN bus in virtual time, with arbitration by id, true frame
 * durations (1/5 Mbit/s; classic 1 Mbit/s) and bounded queues, deterministic. live_bus.c: a real bus, in real time
 * (live_bus.h).
 *
 * Nodes send frames that are ready at some time; bus_run_until() plays the traffic up to a time and hands each frame,
 * at its end, to every other node and to the listener. Time is in ns since the start of the simulation. */
#ifndef COMANIP_SIM_BUS_H
#define COMANIP_SIM_BUS_H

#include <stdbool.h>
#include <stdint.h>

#include "../../firmware/protocol/can_frame.h"
#include "../../firmware/protocol/can_profile.h"

#define BUS_MAX_NODES 16
#define BUS_QUEUE_FRAMES 64

/* frame->timestamp_us is the time of the frame's end. Handlers may call bus_send(). */
typedef void (*bus_handler_t)(void *context, const can_frame_t *frame, int64_t end_ns);

typedef struct {
    uint64_t frames;
    uint64_t dropped; /* refused by a full queue */
    int64_t busy_ns;
    double load_percent_peak; /* over windows of 10 ms */
} bus_statistics_t;

typedef struct bus bus_t;

bus_t *bus_create(can_profile_t profile);
void bus_destroy(bus_t *self);

/* What the nodes have agreed on. */
can_profile_t bus_profile(const bus_t *self);

/* Gives the node's number. At most BUS_MAX_NODES. A node without a handler (NULL) only sends. */
int bus_attach(bus_t *self, bus_handler_t handler, void *context);

/* A listener gets every frame, whoever sent it, before the nodes do, and cannot send. At most BUS_MAX_NODES. */
void bus_listen(bus_t *self, bus_handler_t handler, void *context);

/* Queues a copy, to be sent from ready_ns on (not before the bus's present time). Within one node the lowest id goes
 * first, equal ids in the order of sending. False if the node's queue is full: the frame is dropped and counted. The id
 * must have 11 bits and the length a DLC. */
bool bus_send(bus_t *self, int node, const can_frame_t *frame, int64_t ready_ns);

/* Plays every frame that starts before time_ns; one that is still on the wire then ends, and is delivered, in the next
 * call. */
void bus_run_until(bus_t *self, int64_t time_ns);

/* What the clock that stamps the log, and that of the firmware, modulo 2^32 us, shows at time 0. Virtual time: 0. */
int64_t bus_epoch_ns(const bus_t *self);

bus_statistics_t bus_statistics(const bus_t *self);

#endif
