/* Processes the frames received in a tick: see controller_inputs.h. */
#include "controller_inputs.h"

typedef struct {
    const can_frame_t *frame;
    frame_kind_t kind;
    uint8_t index;        /* index in the inbox */
    uint32_t received_us; /* time of reception, not after now_us */
    uint32_t now_us;
} received_t;

static void take_hand_pose(controller_t *self, const received_t *received) {
    hand_pose_t pose;
    hand_pose_unpack(received->frame, &pose);
    if (!hand_tracker_receive(&self->hand_tracker, &pose, received->received_us, received->now_us)) {
        self->receiver.protocol.rejected += pose.valid;
        return;
    }
    if (self->predicts) {
        const int32_t later_us = (int32_t)(1e6f * self->parameters.value[PARAMETER_TRACKER_LATENCY_S]);
        const uint32_t captured_us = hand_tracker_captured_us(&self->hand_tracker) - (uint32_t)later_us;
        hand_motion_sample(&self->marker_motion, hand_tracker_newest(&self->hand_tracker), captured_us,
                           received->now_us);
    }
}

static void take_tracker_status(controller_t *self, const received_t *received) {
    tracker_status_t status;
    tracker_status_unpack(received->frame, &status);
    hand_tracker_status(&self->hand_tracker, &status);
}

static void take_joint_state(controller_t *self, const received_t *received) {
    joint_state_t state;
    joint_state_unpack(received->frame, &state);
    const int joint = (int)received->kind - (int)FRAME_JOINT_STATE0;
    self->measured_rad[joint] = state.position_rad;
    joint_watch_report(&self->joint_watch, joint, &state, received->received_us);
}

static void note_request(controller_t *self, const received_t *received) {
    self->request[self->request_count].kind = received->kind;
    self->request[self->request_count++].index = received->index;
}

static void take_operator_command(controller_t *self, const received_t *received) {
    note_request(self, received);
}

static void take_task_define(controller_t *self, const received_t *received) {
    note_request(self, received);
}

static void take_parameter_access(controller_t *self, const received_t *received) {
    note_request(self, received);
}

/* Calls the handler for the frame's kind. Compilation fails if the DBC lists a frame as received by the firmware but
 * there is no handler for it here. */
static void take(controller_t *self, const received_t *received) {
    switch (received->kind) {
#define TAKE(NAME, name)                                                                                               \
    case FRAME_##NAME: take_##name(self, received); break;
        COMANIP_RECEIVED(TAKE)
    default: break;
    }
}

void controller_receive(controller_t *self, uint32_t now_us, controller_inbox_t *inbox) {
    self->request_count = 0;
    for (uint8_t i = 0; i < inbox->count; i++) {
        can_frame_t *frame = &inbox->frame[i];
        frame_kind_t kind;
        if (transport_receive(&self->receiver, frame, &kind) == PROTOCOL_OK) {
            const bool after_now = (int32_t)(now_us - frame->timestamp_us) < 0;
            const uint32_t received_us = after_now ? now_us : frame->timestamp_us;
            take(self, &(received_t){frame, kind, i, received_us, now_us});
        }
    }
}

/* The encoders were sampled one tick ago, when the last command arrived. With prediction, self->hand is therefore the
 * pose of the hand at that time. */
void controller_update_hand(controller_t *self, uint32_t now_us) {
    if (self->predicts && self->marker_motion.is_running) {
        self->hand = hand_motion_pose(&self->marker_motion, now_us, -controller_tick_s(self));
        if (!self->marker_is_hand) {
            const vector3_t marker_m = self->hand.translation_m;
            self->hand = pose_multiply(self->hand, self->marker_to_hand);
            self->lever_m = vector3_add(self->hand.translation_m, vector3_scale(marker_m, -1.0f));
        }
    } else {
        self->hand = pose_multiply(hand_tracker_pose(&self->hand_tracker, now_us), self->marker_to_hand);
        self->lever_m = (vector3_t){0.0f, 0.0f, 0.0f};
    }
}

void controller_supervise(controller_t *self, uint32_t now_us) {
    self->supervisor_inputs = (supervisor_inputs_t){
        .joints = joint_watch_check(&self->joint_watch, now_us),
        .powered = self->joint_watch.is_powered,
        .tracker_fresh =
            !hand_tracker_check_stale(&self->hand_tracker, now_us, self->parameters.value[PARAMETER_STALE_PERIODS]),
        .finite = self->finite,
    };
    supervisor_update(&self->supervisor, &self->supervisor_inputs);
    if (!self->hand_tracker.has_pose) {
        hand_motion_reset(&self->marker_motion);
    }
}
