/* Counts how often an object was held by nobody after it was held. A hand-over within an instant does not count. */
#ifndef COMANIP_SIM_DROP_COUNTER_H
#define COMANIP_SIM_DROP_COUNTER_H

#include <stdbool.h>
#include <stdint.h>

#define DROP_COUNTER_TICKS 20 /* of 1 ms: so long in nobody's hand is a drop */

typedef struct {
    bool was_held;
    uint64_t free_ticks; /* since it was last held */
} drop_counter_t;

/* One tick. True in the tick in which a drop becomes one. */
bool drop_counter_sample(drop_counter_t *self, bool is_held);

#endif
