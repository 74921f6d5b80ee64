/* A listener on the bus that keeps what the frames say: modes, parameters, and one record per tick. The monitors know
 * the firmware through it alone. It shares code with the firmware: checking and unpacking of frames (can_protocol.h),
 * the parameters' numbers and defaults, and the translation of a dual quaternion. The tests decode the same logs
 * without it. */
#ifndef COMANIP_SIM_OBSERVER_H
#define COMANIP_SIM_OBSERVER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "../../firmware/parameters/parameters.h"
#include "../../firmware/protocol/can_transport.h"
#include "../bus/bus.h"
#include "../common/rigid_pose.h"
#include "../robot/robot_model.h"
#include "bus_delays.h"
#include "limit_monitor.h"

typedef struct {
    double t_s;
    control_mode_t mode;
    reason_t reason;
} mode_change_t;

#define OBSERVER_PAST_TICKS 8

/* One tick of 1 ms: where the arm was, what the firmware aimed at and what it commanded. On classic CAN the firmware
 * aims each 4 ms, which the bus tells some ms later: its target is kept until the next one. */
typedef struct {
    int64_t time_ns;
    rigid_pose_t hand; /* ODE's */
    control_mode_t mode;
    bool has_target;
    rigid_pose_t target;
    int64_t target_ns;           /* its own time */
    rigid_pose_t hand_at_target; /* ODE's hand at the target's own time; on CAN FD that of this tick */
    bool has_command;
    joint_cmd_t command;
    double measured_rad[ROBOT_JOINTS]; /* as the drives report it */
} tick_record_t;

typedef struct {
    const bus_t *bus;
    transport_receiver_t receiver;
    tick_record_t tick;
    rigid_pose_t past_hand[OBSERVER_PAST_TICKS]; /* ring, by the number of the tick */
    uint64_t ticks;
    uint32_t target_ticks; /* a target counts for so many from its own on */
    uint32_t target_ticks_left;
    double defined_blend_s, blend_s; /* of the last TaskDefine; of the task that was chosen last */
    int64_t
        settled_ns; /* when what the operator last had accepted is in force: until then the target moves by itself */
    float parameter[PARAMETER_COUNT]; /* in force; defaults until the bus says otherwise */
    mode_change_t *modes;
    size_t mode_count;
    size_t mode_capacity;
    uint8_t firmware_rejected_last; /* FirmwareStatus counts modulo 256 */
    uint64_t firmware_rejected;
    limit_monitor_t limits;
    bus_delays_t delays;
    uint32_t tracker_clock_us; /* what the tracker's clock showed at time 0 */
    bool out_of_memory;
} observer_t;

void observer_init(observer_t *self, bus_t *bus, uint32_t tracker_clock_us);
void observer_free(observer_t *self);

/* A new tick: frames received from here on belong to it. */
void observer_begin_tick(observer_t *self, int64_t time_ns, const rigid_pose_t *hand);

#endif
