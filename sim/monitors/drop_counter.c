#include "drop_counter.h"

bool drop_counter_sample(drop_counter_t *self, bool is_held) {
    self->was_held = self->was_held || is_held;
    self->free_ticks = is_held || !self->was_held ? 0 : self->free_ticks + 1;
    return self->free_ticks == DROP_COUNTER_TICKS;
}
