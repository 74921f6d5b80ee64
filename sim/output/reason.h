/* Writes one line that says why a run passed or failed. It also reports dropped objects, skipped checks, times in mode
 * hold, and targets out of reach, which the list of checks does not show. */
#ifndef COMANIP_SIM_REASON_H
#define COMANIP_SIM_REASON_H

#include "checks.h"

/* Fills checks->reason from its other members. */
void reason_write(checks_t *checks, const world_t *world);

#endif
