/* The part of the replay that reconstructs which parameters the recorded firmware loaded from its store, and with which
 * result it saved parameters. */
#ifndef COMANIP_REPLAY_STORE_H
#define COMANIP_REPLAY_STORE_H

#include "replay.h"

/* Initialises the controller as at boot, with the parameters that the firmware announces in the following frames of the
 * log. Parameters that are not announced before the log ends get their defaults. */
void replay_boot(replay_t *self, const arm_ik_t *ik);

/* Returns the ParameterValue in a frame from the log or from the replay. */
parameter_value_t replay_parameter_value(const replay_t *self, const can_frame_t *frame);

/* Checks after a step whether the recorded tick also sent the answer to a save. If so, puts the result of the save into
 * the inbox and returns true. */
bool replay_ends_save(replay_t *self);

#endif
