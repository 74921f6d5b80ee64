/* The robot's gripper as a node on the bus: executes GripperCommand (from the operator) and reports GripperState. */
#ifndef COMANIP_SIM_GRIPPER_NODE_H
#define COMANIP_SIM_GRIPPER_NODE_H

#include <stdint.h>

#include "../bus/bus.h"
#include "../scene/scene.h"

typedef struct gripper_node gripper_node_t;

/* The scene must outlive the node. Returns NULL if out of memory. */
gripper_node_t *gripper_node_create(bus_t *bus, scene_t *scene);
void gripper_node_destroy(gripper_node_t *self);

/* Queues the periodic GripperState frames that are due in [from_ns, until_ns). */
void gripper_node_step(gripper_node_t *self, int64_t from_ns, int64_t until_ns);

/* Returns the number of frames rejected so far, including those with an unknown action. */
uint32_t gripper_node_rejected(const gripper_node_t *self);

#endif
