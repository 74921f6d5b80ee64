/* Measures the delays of frames on the bus: how old a hand pose is when it arrives, and how long a command takes to
 * arrive. */
#ifndef COMANIP_SIM_BUS_DELAYS_H
#define COMANIP_SIM_BUS_DELAYS_H

#include <stdbool.h>
#include <stdint.h>

#include "../../firmware/protocol/can_protocol.h"

typedef struct {
    uint64_t poses, commands;
    double pose_age_us; /* sum of the times from the time stamp of a HandPose to the end of its frame */
    double command_us;  /* sum of the times from the firmware's tick to the end of its JointCmd */
    bool has_latency;
    double reported_latency_us; /* time from measurement to frame, as reported in TrackerStatus */
    bool has_command;
    uint32_t command_end_us;
} bus_delays_t;

/* Adds a HandPose. tracker_us: the tracker's clock at the end of the frame. */
void bus_delays_pose(bus_delays_t *self, const hand_pose_t *pose, uint32_t tracker_us);
void bus_delays_tracker(bus_delays_t *self, const tracker_status_t *status);

/* Add a JointCmd and a TickTrace. All times are on the firmware's clock. */
void bus_delays_command(bus_delays_t *self, uint32_t end_us);
void bus_delays_trace(bus_delays_t *self, const tick_trace_t *trace);

/* Return the latency that the tracker reports, and the mean delays of poses and commands, in ms; NaN without data. */
double bus_delays_tracker_ms(const bus_delays_t *self);
double bus_delays_pose_ms(const bus_delays_t *self); /* delay on the bus, without the tracker's latency */
double bus_delays_command_ms(const bus_delays_t *self);

#endif
