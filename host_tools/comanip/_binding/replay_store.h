/* What the recorded firmware had from its port's store; a part of the replay. */
#ifndef COMANIP_REPLAY_STORE_H
#define COMANIP_REPLAY_STORE_H

#include "replay.h"

/* A controller as it was after the boot that the next frames tell of: with the parameters that they announce. What is
 * not announced, for the log ends before, has its default. */
void replay_boot(replay_t *self, const arm_ik_t *ik);

/* What the log's frame, or one that was sent, tells. */
parameter_value_t replay_parameter_value(const replay_t *self, const can_frame_t *frame);

/* After a step. True: in this tick the answer to a save was sent as well; the inbox now says so. */
bool replay_ends_save(replay_t *self);

#endif
