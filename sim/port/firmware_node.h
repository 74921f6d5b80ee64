/* The firmware's node on the simulated bus: receive queue and send time. The firmware in this process
 * (local_firmware.h) and the firmware in an image (remote_firmware.h) share it, so that both give the same run. */
#ifndef COMANIP_SIM_FIRMWARE_NODE_H
#define COMANIP_SIM_FIRMWARE_NODE_H

#include "../world/world.h"

#define FIRMWARE_NODE_QUEUE_FRAMES 64
/* Assumed time from the tick to the frames it produces: ten times longer than a host needs. */
#define FIRMWARE_NODE_COMPUTE_TIME_NS 50000

typedef struct {
    world_t *world;
    int node;
    can_frame_t queue[FIRMWARE_NODE_QUEUE_FRAMES]; /* ring */
    size_t first, count;
    uint32_t refused_frames; /* sent, but the queue of the bus was full */
} firmware_node_t;

/* Attaches the node to the world's bus. self must keep its address. */
void firmware_node_attach(firmware_node_t *self, world_t *world);

/* Gives the oldest received frame. Returns false if there is none. */
bool firmware_node_receive(firmware_node_t *self, can_frame_t *frame);

/* Sends a frame of the current tick. Returns false if the queue of the bus is full: the frame is then dropped. */
bool firmware_node_send(firmware_node_t *self, const can_frame_t *frame);

#endif
