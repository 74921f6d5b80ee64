/* The arm's drives as a node on the bus: one velocity servo with encoder, brake and command watchdog per joint.
 *
 * On each valid JointCmd, which is their SYNC, all drives latch their command and sample their encoder, and answer with
 * one JointState each. Servo: the commanded velocity passes a first-order lag (current and velocity loop), and the
 * motor follows it with limited torque. Brake: holds. Without a JointCmd for its timeout a drive brakes by itself and
 * reports DRIVE_ERROR_COMMAND_TIMEOUT every tick until the next JointCmd. Before the first JointCmd: brake, no error,
 * silent. Without power from the enable line they brake, whatever is commanded; this is no error. */
#ifndef COMANIP_SIM_DRIVE_NODE_H
#define COMANIP_SIM_DRIVE_NODE_H

#include <stdbool.h>
#include <stdint.h>

#include "../bus/bus.h"
#include "../scene/arm_plant.h"

#define DRIVE_SERVO_TIME_CONSTANT_S 0.003
#define DRIVE_RESPONSE_NS 20000 /* from the end of JointCmd to a JointState ready to be sent */

typedef struct drive_node drive_node_t;

/* The plant must outlive the node. */
drive_node_t *drive_node_create(bus_t *bus, arm_plant_t *plant);
void drive_node_destroy(drive_node_t *self);

/* The enable line, from now on. On until somebody says so: a firmware on a real bus has none here. */
void drive_node_enable(drive_node_t *self, bool enabled);

/* Drives the plant's motors over the next step, from now_ns on. */
void drive_node_step(drive_node_t *self, int64_t now_ns, double step_s);

/* What the joint's encoder reads now. */
double drive_node_encoder_rad(const drive_node_t *self, int joint);

/* JointCmd frames refused so far. */
uint32_t drive_node_rejected(const drive_node_t *self);

#endif
