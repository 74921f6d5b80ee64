/* A ring buffer with the last frames of the bus: see journal.h. */
#include "journal.h"

#include <string.h>

_Static_assert((JOURNAL_FRAMES & (JOURNAL_FRAMES - 1)) == 0, "a power of two, so that positions may wrap at 2^64");

bool journal_accepts(const void *packet, size_t bytes) {
    if (bytes != CAN_MTU && bytes != CANFD_MTU) {
        return false;
    }
    struct can_frame head; /* both kinds of frame begin with id and length */
    memcpy(&head, packet, sizeof head);
    const canid_t id = head.can_id & CAN_EFF_MASK;
    const bool is_extended = (head.can_id & (CAN_EFF_FLAG | CAN_ERR_FLAG)) != 0;
    return head.len <= (bytes == CAN_MTU ? CAN_MAX_DLEN : CANFD_MAX_DLEN) && (is_extended || id <= CAN_SFF_MASK);
}

void journal_append(journal_t *self, const void *packet, size_t bytes, uint32_t sender, const struct timespec *time) {
    journal_entry_t *entry = &self->entry[self->end % JOURNAL_FRAMES];
    memcpy(&entry->frame, packet, bytes);
    entry->bytes = bytes;
    entry->sender = sender;
    entry->time = *time;
    self->end++;
}

bool journal_has(const journal_t *self, uint64_t position) {
    return self->end - position <= JOURNAL_FRAMES;
}

const journal_entry_t *journal_at(const journal_t *self, uint64_t position) {
    return &self->entry[position % JOURNAL_FRAMES];
}
