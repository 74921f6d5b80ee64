/* The state of the joints, as reported by the drives. */
#ifndef COMANIP_JOINT_FEEDBACK_H
#define COMANIP_JOINT_FEEDBACK_H

#include "../arms/arm.h"
#include "../protocol/can_protocol.h"

typedef struct {
    uint32_t timeout_us;
    float position_rad[ARM_MAX_JOINTS];
    drive_error_t error[ARM_MAX_JOINTS];
    uint32_t received_us[ARM_MAX_JOINTS];
    bool received[ARM_MAX_JOINTS];
} joint_feedback_t;

/* timeout_us: timeout of JointState on this bus. */
void joint_feedback_init(joint_feedback_t *self, uint32_t timeout_us);

/* Takes a drive's report. joint: 0..ARM_MAX_JOINTS - 1. received_us: must not be after the time of the next check. */
void joint_feedback_receive(joint_feedback_t *self, int joint, const joint_state_t *state, uint32_t received_us);

/* Returns true if every joint has reported within the timeout. Call it once per tick: it discards a report that has
 * timed out, which would otherwise look fresh again when the clock wraps after 71 minutes. */
bool joint_feedback_check_fresh(joint_feedback_t *self, int joint_count, uint32_t now_us);

/* Returns true if any drive reports an error. */
bool joint_feedback_has_error(const joint_feedback_t *self, int joint_count);

#endif
