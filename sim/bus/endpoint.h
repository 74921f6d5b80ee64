/* A node's side of the bus: whole messages, whatever the bus's profile is. */
#ifndef COMANIP_SIM_ENDPOINT_H
#define COMANIP_SIM_ENDPOINT_H

#include "../../firmware/protocol/can_transport.h"
#include "bus.h"

#define ENDPOINT_KIND(kind) (UINT32_C(1) << (kind))

/* message: as X_unpack() of can_protocol.h wants it. end_ns: of its last frame. */
typedef void (*endpoint_handler_t)(void *context, frame_kind_t kind, const can_frame_t *message, int64_t end_ns);

typedef struct {
    bus_t *bus;
    int node;
    endpoint_handler_t handler;
    void *context;
    transport_sender_t sender;
    transport_receiver_t receiver;
    int64_t ready_ns; /* of the message that is being sent */
} endpoint_t;

/* Attaches a node that gets messages of these kinds (one bit each) from others; handler may be NULL. joint_count: of the
 * arm on this bus. Must not move. */
void endpoint_attach(endpoint_t *self, bus_t *bus, uint8_t joint_count, uint32_t kinds, endpoint_handler_t handler,
                     void *context);

/* Protects and queues the message. A full queue is counted by the bus. */
void endpoint_send(endpoint_t *self, const can_frame_t *message, int64_t ready_ns);

/* Frames refused so far. */
uint32_t endpoint_rejected(const endpoint_t *self);

#endif
