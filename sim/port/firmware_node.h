/* The firmware's node on the simulated bus, which determines when frames are received and sent. The firmware in this
 * process (local_firmware.h) and the firmware in an image (remote_firmware.h) produce the same run, because both use
 * this node. */
#ifndef COMANIP_SIM_FIRMWARE_NODE_H
#define COMANIP_SIM_FIRMWARE_NODE_H

#include "../world/world.h"

#define FIRMWARE_NODE_QUEUE_FRAMES 64
/* Assumed time from a tick until its frames are ready to be sent, ten times longer than a PC needs. */
#define FIRMWARE_NODE_COMPUTE_TIME_NS 50000

typedef struct {
    world_t *world;
    int node;
    can_frame_t queue[FIRMWARE_NODE_QUEUE_FRAMES]; /* ring buffer */
    size_t first, count;
    uint32_t refused_frames; /* frames that could not be sent, because the bus's queue was full */
} firmware_node_t;

/* Attaches the node to the world's bus. self must not move in memory afterwards. */
void firmware_node_attach(firmware_node_t *self, world_t *world);

/* Takes the oldest received frame from the queue. Returns false if the queue is empty. */
bool firmware_node_receive(firmware_node_t *self, can_frame_t *frame);

/* Queues a frame of the current tick on the bus. If the bus's queue is full, drops the frame and returns false. */
bool firmware_node_send(firmware_node_t *self, const can_frame_t *frame);

#endif
