#include "bus_delays.h"

#include <math.h>

#define MS_PER_US 1e-3
#define LONGEST_US 8000 /* two control periods on classic CAN; a longer delay: command and trace of different ticks */

void bus_delays_pose(bus_delays_t *self, const hand_pose_t *pose, uint32_t tracker_us) {
    self->poses++;
    self->pose_age_us += (double)(int32_t)(tracker_us - pose->t_us);
}

void bus_delays_tracker(bus_delays_t *self, const tracker_status_t *status) {
    self->has_latency = true;
    self->reported_latency_us = (double)status->latency_us;
}

void bus_delays_command(bus_delays_t *self, uint32_t end_us) {
    self->has_command = true;
    self->command_end_us = end_us;
}

/* Called after bus_delays_command() of the same tick, because the TickTrace is sent after the JointCmd. */
void bus_delays_trace(bus_delays_t *self, const tick_trace_t *trace) {
    const uint32_t delay_us = self->command_end_us - trace->now_us;
    if (self->has_command && delay_us <= LONGEST_US) {
        self->commands++;
        self->command_us += (double)delay_us;
    }
    self->has_command = false;
}

double bus_delays_tracker_ms(const bus_delays_t *self) {
    return self->has_latency ? MS_PER_US * self->reported_latency_us : (double)NAN;
}

double bus_delays_pose_ms(const bus_delays_t *self) {
    return self->poses > 0 ? MS_PER_US * self->pose_age_us / (double)self->poses - bus_delays_tracker_ms(self)
                           : (double)NAN;
}

double bus_delays_command_ms(const bus_delays_t *self) {
    return self->commands > 0 ? MS_PER_US * self->command_us / (double)self->commands : (double)NAN;
}
