/* The proximity sensor as a node on the bus: sends the measured clearances (Clearance). */
#ifndef COMANIP_SIM_PROXIMITY_NODE_H
#define COMANIP_SIM_PROXIMITY_NODE_H

#include <stdint.h>

#include "../bus/bus.h"
#include "../proximity/proximity.h"

typedef struct proximity_node proximity_node_t;

proximity_node_t *proximity_node_create(bus_t *bus);
void proximity_node_destroy(proximity_node_t *self);

/* Queues the frames that are due in [from_ns, until_ns). */
void proximity_node_step(proximity_node_t *self, const measured_clearance_t *clearance, int64_t from_ns,
                         int64_t until_ns);

#endif
