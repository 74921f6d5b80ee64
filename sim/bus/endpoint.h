/* A node's connection to the bus: sends and receives whole messages in either bus profile. */
#ifndef COMANIP_SIM_ENDPOINT_H
#define COMANIP_SIM_ENDPOINT_H

#include "../../firmware/protocol/can_transport.h"
#include "bus.h"

#define ENDPOINT_KIND(kind) (UINT32_C(1) << (kind))

/* message: in the layout that the X_unpack() functions of can_protocol.h expect. end_ns: end time of its last frame. */
typedef void (*endpoint_handler_t)(void *context, frame_kind_t kind, const can_frame_t *message, int64_t end_ns);

typedef struct {
    bus_t *bus;
    int node;
    endpoint_handler_t handler;
    void *context;
    transport_sender_t sender;
    transport_receiver_t receiver;
    int64_t ready_ns; /* ready time of the message being sent */
} endpoint_t;

/* Attaches a node to the bus. joint_count: joints of the arm on this bus. kinds: the kinds of message that the
 * node receives, one bit each. handler: NULL if the node only sends. self must not be moved afterwards. */
void endpoint_attach(endpoint_t *self, bus_t *bus, uint8_t joint_count, uint32_t kinds, endpoint_handler_t handler,
                     void *context);

/* Adds the E2E protection and queues the message. If the queue is full, the bus drops the frame and counts it. */
void endpoint_send(endpoint_t *self, const can_frame_t *message, int64_t ready_ns);

/* Returns the number of frames rejected so far. */
uint32_t endpoint_rejected(const endpoint_t *self);

#endif
