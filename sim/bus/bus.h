/* The bus that the simulated nodes share. bus.c is a deterministic CAN bus in virtual time, with arbitration by id,
 * exact frame durations (CAN FD 1/5 Mbit/s, classic CAN 1 Mbit/s) and bounded queues. live_bus.c is a real bus in real
 * time (live_bus.h).
 *
 * A node queues each frame together with the time at which it is ready to be sent. bus_run_until() runs the bus up to a
 * given time and delivers each frame, at its end, to the listeners and to every other node. Times are in ns since the
 * start of the simulation. */
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
    uint64_t dropped; /* frames rejected because a queue was full */
    int64_t busy_ns;
    double load_percent_peak; /* highest load in any of the consecutive windows of 10 ms */
} bus_statistics_t;

typedef struct bus bus_t;

bus_t *bus_create(can_profile_t profile);
void bus_destroy(bus_t *self);

/* Returns the profile that all nodes of the bus use. */
can_profile_t bus_profile(const bus_t *self);

/* Adds a node and returns its index; at most BUS_MAX_NODES. A node without a handler (NULL) only sends. */
int bus_attach(bus_t *self, bus_handler_t handler, void *context);

/* Adds a listener, which receives every frame before the nodes do and cannot send. At most BUS_MAX_NODES. */
void bus_listen(bus_t *self, bus_handler_t handler, void *context);

/* Queues a copy of the frame, to be sent no earlier than ready_ns and no earlier than the current bus time. Each node
 * sends its lowest id first, and frames with equal ids in the order of the calls. Returns false if the node's queue is
 * full; the frame is then dropped and counted. The id must fit in 11 bits, and the length must be one that a DLC can
 * encode. */
bool bus_send(bus_t *self, int node, const can_frame_t *frame, int64_t ready_ns);

/* Transmits every frame that starts before time_ns. A frame still on the wire at time_ns is delivered by the next
 * call. */
void bus_run_until(bus_t *self, int64_t time_ns);

/* Returns the time [ns] that the log's clock shows at time 0 of the simulation. The firmware's clock then shows the
 * same time, modulo 2^32 us. Returns 0 in virtual time. */
int64_t bus_epoch_ns(const bus_t *self);

bus_statistics_t bus_statistics(const bus_t *self);

#endif
