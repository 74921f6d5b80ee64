/* The firmware's node on the simulated bus: its receive queue, and when it sends. The firmware in this process
 * (local_firmware.h) and the one in an image (remote_firmware.h) have it in common, so that the same run comes out. */
#ifndef COMANIP_SIM_FIRMWARE_NODE_H
#define COMANIP_SIM_FIRMWARE_NODE_H

#include "../world/world.h"

#define FIRMWARE_NODE_QUEUE_FRAMES 64
/* Assumed, from the tick to the frames it produces: an order above what this machine needs. */
#define FIRMWARE_NODE_COMPUTE_TIME_NS 50000

typedef struct {
    world_t *world;
    int node;
    can_frame_t queue[FIRMWARE_NODE_QUEUE_FRAMES]; /* ring */
    size_t first, count;
} firmware_node_t;

/* Attaches it to the world's bus. Must not move. */
void firmware_node_attach(firmware_node_t *self, world_t *world);

/* The oldest received frame. False: none left. A frame that finds the queue full is counted by the world. */
bool firmware_node_receive(firmware_node_t *self, can_frame_t *frame);

/* Sends a frame of the tick under way. False: the bus's queue is full. */
bool firmware_node_send(firmware_node_t *self, const can_frame_t *frame);

#endif
