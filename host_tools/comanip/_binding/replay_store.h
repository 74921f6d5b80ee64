/* Reconstructs what the recorded firmware had read from its store, and the outcome of saves. A part of the replay. */
#ifndef COMANIP_REPLAY_STORE_H
#define COMANIP_REPLAY_STORE_H

#include "replay.h"

/* Initialises the controller as after the boot that the next frames announce, with the announced parameters. Parameters
 * that are not announced before the log ends have their defaults. */
void replay_boot(replay_t *self, const arm_ik_t *ik);

/* The ParameterValue in a frame of the log, or in one that was sent. */
parameter_value_t replay_parameter_value(const replay_t *self, const can_frame_t *frame);

/* To be called after a step. True if the recorded tick also sent the answer to a save; the inbox now has its result. */
bool replay_ends_save(replay_t *self);

#endif
