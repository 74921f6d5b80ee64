#include "gripper_node.h"

#include <math.h>
#include <stdlib.h>

#include "../../firmware/can_protocol.h"

#define NS_PER_MS 1000000
#define RESPONSE_NS 20000   /* from the end of GripperCommand to the GripperState that answers it */
#define END_OF_STROKE 1e-3  /* so near to its end the stroke is over */
#define FORCE_MAX_N 6500.0  /* the frame carries 6553.5 N: a spike beyond is told as this */

struct gripper_node {
    bus_t *bus;
    int node;
    scene_t *scene;
    protocol_receiver_t receiver;
    protocol_sender_t sender;
    bool commanded; /* there has been a command */
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
        protocol_protect(&self->sender, &frame);
        (void)bus_send(self->bus, self->node, &frame, ready_ns); /* a full queue is counted by the bus */
    }
}

static void on_frame(void *context, const can_frame_t *frame, int64_t end_ns) {
    gripper_node_t *self = context;
    frame_kind_t kind;
    if (frame->id != frame_table[FRAME_GRIPPER_COMMAND].id ||
        protocol_check(&self->receiver, frame, &kind) != PROTOCOL_OK) {
        return;
    }
    gripper_command_t command;
    gripper_command_unpack(frame, &command);
    if (command.action > GRIPPER_CLOSE) {
        self->receiver.rejected++; /* unknown: not obeyed, and not answered */
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
        self->bus = bus;
        self->scene = scene;
        self->node = bus_attach(bus, on_frame, self);
    }
    return self;
}

void gripper_node_destroy(gripper_node_t *self) {
    free(self);
}

void gripper_node_step(gripper_node_t *self, int64_t from_ns, int64_t until_ns) {
    const int64_t period_ns = (int64_t)frame_table[FRAME_GRIPPER_STATE].period_ms * NS_PER_MS;
    for (int64_t due_ns = (from_ns + period_ns - 1) / period_ns * period_ns; due_ns < until_ns; due_ns += period_ns) {
        send_state(self, due_ns);
    }
}

uint32_t gripper_node_rejected(const gripper_node_t *self) {
    return self->receiver.rejected;
}
