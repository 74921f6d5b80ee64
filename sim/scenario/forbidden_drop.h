/* What fell although a check of the scenario says that it must not: of kind `drops`, whose limit it exceeds. An object
 * that is put down on purpose, in a scenario without such a check, has not fallen. */
#ifndef COMANIP_SIM_FORBIDDEN_DROP_H
#define COMANIP_SIM_FORBIDDEN_DROP_H

#include "scenario.h"

/* The event "OBJECT.dropped" of an object that fell; NULL: it did not, or may. */
const event_t *forbidden_drop(const scenario_t *scenario, const events_t *events, size_t object);

#endif
