/* Watches every JointCmd on the bus for position, velocity, acceleration and jerk limits: the manual's (robot_model.h),
 * and the parameters' values. Shares with the firmware the unpacking of the frame (firmware/protocol/can_protocol.h),
 * and neither the arm's table nor the code that keeps the limits. */
#ifndef COMANIP_SIM_LIMIT_MONITOR_H
#define COMANIP_SIM_LIMIT_MONITOR_H

#include <stdbool.h>
#include <stdint.h>

#include "../../firmware/arms/arm.h"
#include "../../firmware/protocol/can_protocol.h"
#include "../robot/robot_model.h"

typedef struct {
    bool has_last;
    int64_t last_ns;
    double last_velocity_radps[ROBOT_JOINTS];
    double last_interval_s; /* from the command before to the last one; 0: there was none before */
    double last_acceleration_radps2[ROBOT_JOINTS]; /* the mean in it */
    uint64_t violations; /* limits broken, each joint and kind counted by itself, and frames not to be decoded */
    char first[120];     /* the first of them in words; "" */
} limit_monitor_t;

void limit_monitor_init(limit_monitor_t *self);

/* The parameters speed_fraction and acceleration_limit_radps2 in force. After a smaller speed_fraction a joint may
 * still brake down to it at its limits of acceleration and jerk. */
void limit_monitor_command(limit_monitor_t *self, const joint_cmd_t *command, int64_t end_ns, double speed_fraction,
                           double acceleration_max_radps2);

/* A JointCmd that its receivers refuse. */
void limit_monitor_undecodable(limit_monitor_t *self, int64_t end_ns);

#endif
