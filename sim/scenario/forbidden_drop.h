/* Finds objects that were dropped more often than a `drops` check of the scenario allows. Without such a check, drops
 * are allowed, because a person may put an object down on purpose. */
#ifndef COMANIP_SIM_FORBIDDEN_DROP_H
#define COMANIP_SIM_FORBIDDEN_DROP_H

#include "scenario.h"

/* Returns the event "OBJECT.dropped" if the drops of the object exceed the limit of a check, else NULL. */
const event_t *forbidden_drop(const scenario_t *scenario, const events_t *events, size_t object);

#endif
