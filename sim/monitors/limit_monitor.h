/* Checks every JointCmd on the bus against the position, velocity, acceleration and jerk limits of the manual
 * (robot_model.h) and of the parameters. The monitor shares with the firmware only the unpacking of the frame
 * (firmware/protocol/can_protocol.h), not the arm's table or the code that enforces the limits. */
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
    double last_interval_s;                        /* time between the last two commands; 0: fewer than two so far */
    double last_acceleration_radps2[ROBOT_JOINTS]; /* mean acceleration in that interval */
    uint64_t violations; /* violated limits, each joint and kind counted separately, and undecodable frames */
    char first[120];     /* text of the first violation; "": none */
} limit_monitor_t;

void limit_monitor_init(limit_monitor_t *self);

/* Checks a command against the current parameters speed_fraction and acceleration_limit_radps2. After speed_fraction is
 * reduced, a joint may exceed the new speed limit for as long as it needs to brake within its acceleration and jerk
 * limits. */
void limit_monitor_command(limit_monitor_t *self, const joint_cmd_t *command, int64_t end_ns, double speed_fraction,
                           double acceleration_max_radps2);

/* Counts a JointCmd that receivers reject because it cannot be decoded. */
void limit_monitor_undecodable(limit_monitor_t *self, int64_t end_ns);

#endif
