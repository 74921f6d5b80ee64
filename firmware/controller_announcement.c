/* Sends the identity and the parameters after boot: see controller_announcement.h. */
#include "controller_announcement.h"

#include "comanip_identity.h"
#include "controller_outputs.h"

static void send_identity(controller_t *self, controller_outbox_t *outbox) {
    firmware_identity_t identity = {
        .build_hash = COMANIP_BUILD_HASH,
        .arm = self->arm->id,
        .joint_count = self->arm->joint_count,
        .parameter_count = PARAMETER_COUNT,
        .trace_version = COMANIP_TRACE_VERSION,
        .trace_hash = COMANIP_TRACE_HASH,
    };
    can_frame_t frame;
    (void)firmware_identity_pack(&identity, &frame);
    controller_send(self, &frame, outbox);
}

static result_t announced_result(const controller_t *self, uint8_t parameter) {
    const bool unstable =
        self->parameter_set.verdict == PARAMETER_SET_UNSTABLE && (self->parameter_set.involved >> parameter & 1u) != 0u;
    return unstable ? RESULT_PARAMETERS_UNSTABLE : self->boot_result;
}

void controller_announce_parameter(controller_t *self, uint8_t parameter, controller_outbox_t *outbox) {
    controller_send_parameter(self, parameter, 0, announced_result(self, parameter), outbox);
}

void controller_announce(controller_t *self, controller_outbox_t *outbox) {
    if (self->announced > PARAMETER_COUNT) {
        return;
    }
    const uint8_t parameter = (uint8_t)(self->announced - 1u);
    if (self->announced == 0u) {
        send_identity(self, outbox);
    } else if (parameters_has(parameter)) {
        controller_announce_parameter(self, parameter, outbox);
    }
    self->announced++;
}
