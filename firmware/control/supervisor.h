/* The state machine of the control modes, with the reason for each transition. */
#ifndef COMANIP_SUPERVISOR_H
#define COMANIP_SUPERVISOR_H

#include "../protocol/can_protocol.h"

typedef struct {
    bool drives_fresh;
    bool drive_error;
    bool tracker_fresh;
    bool finite; /* all numbers computed in the last tick were finite */
} supervisor_inputs_t;

typedef struct {
    control_mode_t mode;
    reason_t reason;
} supervisor_t;

void supervisor_init(supervisor_t *self);

/* Updates the mode from the inputs, once per tick:
 *   idle <-> ready              ready while the data of drives and tracker are fresh and no drive reports an error
 *   cooperating <-> hold        hold while the tracker's data are stale
 *   cooperating, hold -> fault  if a drive stops responding or reports an error, or a number is not finite */
void supervisor_update(supervisor_t *self, const supervisor_inputs_t *inputs);

/* Changes from ready to cooperating. */
result_t supervisor_start(supervisor_t *self);

/* Changes from cooperating or hold to ready. Changes from fault to idle, unless a cause of a fault is still present;
 * then returns RESULT_FAULT_PRESENT. Does not change the modes idle and ready. */
result_t supervisor_stop(supervisor_t *self, const supervisor_inputs_t *inputs);

/* Returns true in mode cooperating or hold. */
static inline bool supervisor_is_engaged(const supervisor_t *self) {
    return self->mode == MODE_COOPERATING || self->mode == MODE_HOLD;
}

stop_category_t supervisor_stop_category(const supervisor_t *self);

#endif
