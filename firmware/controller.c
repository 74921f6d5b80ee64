/* The stages of a tick in their order: see controller.h. */
#include "controller.h"

#include <string.h>

#include "controller_announcement.h"
#include "controller_demand.h"
#include "controller_inputs.h"
#include "controller_outputs.h"
#include "controller_parameters.h"
#include "controller_requests.h"

/* Bit mask of the frame kinds that the firmware receives. */
#define KIND_BIT(NAME, name) | UINT32_C(1) << FRAME_##NAME
#define RECEIVED_KINDS (0u COMANIP_RECEIVED(KIND_BIT))

void controller_init(controller_t *self, const arm_ik_t *ik, can_profile_t profile) {
    memset(self, 0, sizeof *self);
    self->ik = ik;
    self->arm = ik->arm;
    self->tick_ms = transport_period_ms(profile, FRAME_JOINT_CMD);
    transport_sender_init(&self->sender, profile, ik->arm->joint_count);
    transport_receiver_init(&self->receiver, profile, ik->arm->joint_count, RECEIVED_KINDS);
    hand_tracker_init(&self->hand_tracker, 1000u * transport_period_ms(profile, FRAME_HAND_POSE));
    hand_motion_init(&self->marker_motion);
    joint_watch_init(&self->joint_watch, self->arm, self->tick_ms,
                     1000u * transport_timeout_ms(profile, FRAME_JOINT_STATE0));
    supervisor_init(&self->supervisor);
    posture_change_init(&self->posture_change);
    joint_limits_init(&self->limits);
    self->finite = true;
    parameters_t defaults;
    parameters_set_defaults(&defaults);
    controller_set_parameters(self, &defaults, RESULT_ACCEPTED);
}

void controller_set_parameters(controller_t *self, const parameters_t *parameters, result_t result) {
    self->parameters = *parameters;
    self->boot_result = result;
    controller_apply_parameters(self);
    controller_select_task(self, TASK_TELEOP, &task_table[TASK_TELEOP], self->parameters.value[PARAMETER_TASK_BLEND_S]);
}

void controller_step(controller_t *self, uint32_t now_us, controller_inbox_t *inbox, controller_outbox_t *outbox) {
    outbox->save = false;
    self->cooperation_changed = false;

    controller_receive(self, now_us, inbox);
    controller_update_hand(self, now_us);
    controller_supervise(self, now_us);
    controller_finish_save(self, inbox, outbox);
    controller_report_unstable(self, outbox);
    controller_handle_requests(self, inbox, outbox);
    controller_compute_demand(self, now_us);
    self->finite = joint_limits_apply(&self->limits, self->arm, &self->joint_limits_config, self->measured_rad,
                                      self->feedback_radps, self->feedforward_radps);
    controller_publish(self, now_us, &inbox->port, outbox);
    controller_announce(self, outbox);

    self->tick++;
}
