#include "proximity_node.h"

#include <stdlib.h>

#include "../bus/endpoint.h"

#define NS_PER_MS 1000000

struct proximity_node {
    endpoint_t endpoint;
};

proximity_node_t *proximity_node_create(bus_t *bus) {
    proximity_node_t *self = calloc(1, sizeof *self);
    if (self != NULL) {
        endpoint_attach(&self->endpoint, bus, ROBOT_JOINTS, 0, NULL, NULL);
    }
    return self;
}

void proximity_node_destroy(proximity_node_t *self) {
    free(self);
}

static clearance_t report_of(const measured_clearance_t *clearance) {
    clearance_t report = {
        .person_m = (float)clearance->person_m,
        .self_m = (float)clearance->self_m,
        .person_valid = clearance->person_pair >= 0,
        .self_valid = clearance->self_pair >= 0,
    };
    if (report.person_valid) {
        const proximity_pair_t pair = proximity_pair(clearance->person_pair);
        report.person = (uint8_t)pair.person;
        report.person_part = (uint8_t)pair.part;
        report.robot_part = (uint8_t)pair.robot;
    }
    if (report.self_valid) {
        const proximity_pair_t pair = proximity_pair(clearance->self_pair);
        report.arm_part = (uint8_t)pair.robot;
        report.body_part = (uint8_t)(pair.body - ROBOT_PART_UPPER_ARM);
    }
    return report;
}

void proximity_node_step(proximity_node_t *self, const measured_clearance_t *clearance, int64_t from_ns,
                         int64_t until_ns) {
    const int64_t period_ns = (int64_t)transport_period_ms(self->endpoint.sender.profile, FRAME_CLEARANCE) * NS_PER_MS;
    const clearance_t report = report_of(clearance);
    for (int64_t due_ns = (from_ns + period_ns - 1) / period_ns * period_ns; due_ns < until_ns; due_ns += period_ns) {
        can_frame_t frame;
        if (clearance_pack(&report, &frame) == PROTOCOL_OK) {
            endpoint_send(&self->endpoint, &frame, due_ns);
        }
    }
}
