#include "gripper_node.h"

#include <math.h>
#include <stdlib.h>

#include "../bus/endpoint.h"

#define NS_PER_MS 1000000
#define RESPONSE_NS 20000  /* time from the end of GripperCommand until its answer is ready to be sent */
#define END_OF_STROKE 1e-3 /* share of the stroke; closer than this to an end, the gripper counts as open or closed */
#define FORCE_MAX_N 6500.0 /* limit of the reported force; the frame carries up to 6553.5 N */

struct gripper_node {
    endpoint_t endpoint;
    scene_t *scene;
    uint32_t unknown_actions;
    bool commanded; /* a command has been received */
    gripper_command_t command;
};

static gripper_status_t status_of(const gripper_node_t *self, double opening) {
    const bool closes = self->commanded && self->command.action == GRIPPER_CLOSE;
    const bool opens = self->commanded && self->command.action == GRIPPER_OPEN;
    if (scene_robot_holds(self->scene)) {
        return GRIPPER_STATUS_HOLDING;
    }
    if (opening >= 1.0 - END_OF_STROKE && !closes) {
        return GRIPPER_STATUS_OPEN;
    }
    return opening <= END_OF_STROKE && !opens ? GRIPPER_STATUS_CLOSED : GRIPPER_STATUS_MOVING;
}

static void send_state(gripper_node_t *self, int64_t ready_ns) {
    const double opening = scene_gripper_opening(self->scene);
    const gripper_state_t state = {
        .sequence = self->command.sequence,
        .state = status_of(self, opening),
        .opening_percent = (float)(100.0 * opening),
        .force_N = (float)fmin(scene_gripper_force_N(self->scene), FORCE_MAX_N),
    };
    can_frame_t frame;
    if (gripper_state_pack(&state, &frame) == PROTOCOL_OK) {
        endpoint_send(&self->endpoint, &frame, ready_ns);
    }
}

static void on_command(void *context, frame_kind_t kind, const can_frame_t *message, int64_t end_ns) {
    gripper_node_t *self = context;
    (void)kind;
    gripper_command_t command;
    gripper_command_unpack(message, &command);
    if (command.action > GRIPPER_CLOSE) {
        self->unknown_actions++; /* neither executed nor answered */
        return;
    }
    self->commanded = true;
    self->command = command;
    scene_command_gripper(self->scene, command.action == GRIPPER_CLOSE);
    send_state(self, end_ns + RESPONSE_NS);
}

gripper_node_t *gripper_node_create(bus_t *bus, scene_t *scene) {
    gripper_node_t *self = calloc(1, sizeof *self);
    if (self != NULL) {
        self->scene = scene;
        endpoint_attach(&self->endpoint, bus, ROBOT_JOINTS, ENDPOINT_KIND(FRAME_GRIPPER_COMMAND), on_command, self);
    }
    return self;
}

void gripper_node_destroy(gripper_node_t *self) {
    free(self);
}

void gripper_node_step(gripper_node_t *self, int64_t from_ns, int64_t until_ns) {
    const int64_t period_ns =
        (int64_t)transport_period_ms(self->endpoint.sender.profile, FRAME_GRIPPER_STATE) * NS_PER_MS;
    for (int64_t due_ns = (from_ns + period_ns - 1) / period_ns * period_ns; due_ns < until_ns; due_ns += period_ns) {
        send_state(self, due_ns);
    }
}

uint32_t gripper_node_rejected(const gripper_node_t *self) {
    return endpoint_rejected(&self->endpoint) + self->unknown_actions;
}
