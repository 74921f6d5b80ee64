/* Watches every JointCmd on the bus for position, velocity and acceleration limits. Shares no code and no tables with
 * what it watches: the limits are the manual's (robot_model.h), the acceleration limit is the parameter's value. */
#ifndef COMANIP_SIM_LIMIT_MONITOR_H
#define COMANIP_SIM_LIMIT_MONITOR_H

#include <stdbool.h>
#include <stdint.h>

#include "../firmware/can_protocol.h"
#include "robot_model.h"

typedef struct {
    bool has_last;
    int64_t last_ns;
    double last_velocity_radps[ROBOT_JOINTS];
    uint64_t violations; /* limits broken, each joint and kind counted by itself, and frames not to be decoded */
    char first[120];     /* the first of them in words; "" */
} limit_monitor_t;

void limit_monitor_init(limit_monitor_t *self);

void limit_monitor_command(limit_monitor_t *self, const joint_command_t *command, int64_t end_ns,
                           double acceleration_max_radps2);

/* A JointCmd that its receivers refuse. */
void limit_monitor_undecodable(limit_monitor_t *self, int64_t end_ns);

#endif
