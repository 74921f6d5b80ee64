/* The state machine of the control modes, with the reason for each transition. */
#ifndef COMANIP_SUPERVISOR_H
#define COMANIP_SUPERVISOR_H

#include "../protocol/can_protocol.h"
#include "../safety/joint_watch.h"

typedef struct {
    joint_watch_result_t joints;
    bool powered; /* the drives have power, so the arm moves or may still be braking */
    bool tracker_fresh;
    bool finite; /* all numbers computed in the last tick were finite */
} supervisor_inputs_t;

typedef struct {
    control_mode_t mode;
    reason_t reason;
} supervisor_t;

void supervisor_init(supervisor_t *self);

/* Updates the mode from the inputs, once per tick:
 *   idle <-> ready              ready while the tracker's data are fresh and all drives respond without an error
 *   cooperating <-> hold        hold while the tracker's data are stale
 *   cooperating, hold -> fault  on any finding in the joints, or if a number is not finite
 *   idle, ready -> fault        likewise, while the drives still have power after a stop */
void supervisor_update(supervisor_t *self, const supervisor_inputs_t *inputs);

/* Changes from ready to cooperating. In mode ready, returns RESULT_JOINT_OUT_OF_RANGE unless all joints are in range,
 * and RESULT_NOT_AT_REST unless they are at rest. */
result_t supervisor_start(supervisor_t *self, const supervisor_inputs_t *inputs);

/* Changes from cooperating or hold to ready. Does not change the modes idle and ready. In mode fault, returns
 * RESULT_NOT_ACKNOWLEDGED. */
result_t supervisor_stop(supervisor_t *self);

/* Changes from fault to idle. Returns RESULT_FAULT_PRESENT while a drive is silent or reports an error, and
 * RESULT_NOT_AT_REST while the arm has power or is not at rest. Does not change the modes idle and ready; in all other
 * modes, returns RESULT_WRONG_MODE. */
result_t supervisor_acknowledge(supervisor_t *self, const supervisor_inputs_t *inputs);

/* Returns true in mode cooperating or hold. */
static inline bool supervisor_is_engaged(const supervisor_t *self) {
    return self->mode == MODE_COOPERATING || self->mode == MODE_HOLD;
}

stop_category_t supervisor_stop_category(const supervisor_t *self);

#endif
