/* A listener on the bus that records modes, parameters and one record per tick. It is the monitors' only source of data
 * about the firmware. It shares some code with the firmware: the checking and unpacking of frames (can_transport.h),
 * the numbers and defaults of the parameters, and the normalisation of a quaternion. The tests decode the same logs
 * without this code. */
#ifndef COMANIP_SIM_OBSERVER_H
#define COMANIP_SIM_OBSERVER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "../../firmware/parameters/parameters.h"
#include "../../firmware/protocol/can_transport.h"
#include "../../firmware/protocol/port_status.h"
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

/* One tick of 1 ms: the pose of the end effector, and the firmware's target and command. On classic CAN the firmware
 * computes a target every 4 ms, and the target arrives over the bus a few ms later; each target is kept until the next
 * one arrives. */
typedef struct {
    int64_t time_ns;
    rigid_pose_t hand; /* end effector in ODE */
    control_mode_t mode;
    bool has_target;
    rigid_pose_t target;
    int64_t target_ns;           /* time of the target */
    rigid_pose_t hand_at_target; /* end effector in ODE at target_ns; on CAN FD equal to `hand` */
    bool has_command;
    joint_cmd_t command;
    double measured_rad[ROBOT_JOINTS]; /* as reported by the drives */
} tick_record_t;

typedef struct {
    const bus_t *bus;
    transport_receiver_t receiver;
    tick_record_t tick;
    rigid_pose_t past_hand[OBSERVER_PAST_TICKS]; /* ring buffer, indexed by tick number */
    uint64_t ticks;
    uint32_t target_ticks; /* number of ticks for which a target is valid */
    uint32_t target_ticks_left;
    double defined_blend_s, blend_s; /* blend times of the last TaskDefine and of the task selected last */
    int64_t settled_ns; /* end of the blend of the last accepted command; until then the target may move by itself */
    float parameter[PARAMETER_COUNT]; /* current values; defaults until a ParameterValue arrives */
    mode_change_t *modes;
    size_t mode_count;
    size_t mode_capacity;
    uint8_t firmware_rejected_last; /* FirmwareStatus counts modulo 256 */
    uint64_t firmware_rejected;
    bool has_port;
    port_status_t port; /* the PortStatus received last */
    limit_monitor_t limits;
    bus_delays_t delays;
    uint32_t tracker_clock_us; /* the tracker's clock at time 0 */
    bool out_of_memory;
} observer_t;

void observer_init(observer_t *self, bus_t *bus, uint32_t tracker_clock_us);
void observer_free(observer_t *self);

/* Begins a tick. Frames received from now on belong to it. */
void observer_begin_tick(observer_t *self, int64_t time_ns, const rigid_pose_t *hand);

#endif
