/* The arm's drives as a node on the bus: one velocity servo with encoder, brake and command watchdog per joint.
 *
 * Each valid JointCmd acts like a SYNC message of CANopen: all drives latch their command, sample their encoder and
 * answer with one JointState each. In velocity mode the commanded velocity passes through a first-order lag, which
 * models the current and velocity loops; the motor follows the lagged velocity with limited torque. In brake mode the
 * joint is held. If no JointCmd arrives within the timeout, the drives brake and report DRIVE_ERROR_COMMAND_TIMEOUT at
 * the period of JointState until the next JointCmd. Before the first JointCmd the drives brake, report no error and
 * send nothing. While the enable line is off, the drives brake, whatever is commanded; this is not reported as an
 * error. */
#ifndef COMANIP_SIM_DRIVE_NODE_H
#define COMANIP_SIM_DRIVE_NODE_H

#include <stdbool.h>
#include <stdint.h>

#include "../bus/bus.h"
#include "../scene/arm_plant.h"

#define DRIVE_SERVO_TIME_CONSTANT_S 0.003
#define DRIVE_RESPONSE_NS 20000 /* time from the end of JointCmd until JointState is ready to be sent */

typedef struct drive_node drive_node_t;

/* The plant must outlive the node. */
drive_node_t *drive_node_create(bus_t *bus, arm_plant_t *plant);
void drive_node_destroy(drive_node_t *self);

/* Sets the enable line. It is on initially, because firmware on a real bus cannot control it. */
void drive_node_enable(drive_node_t *self, bool enabled);

/* Sets the velocities of the plant's motors for the step that begins at now_ns. */
void drive_node_step(drive_node_t *self, int64_t now_ns, double step_s);

/* Returns the current reading of the joint's encoder. */
double drive_node_encoder_rad(const drive_node_t *self, int joint);

/* Returns the number of JointCmd frames rejected so far. */
uint32_t drive_node_rejected(const drive_node_t *self);

#endif
