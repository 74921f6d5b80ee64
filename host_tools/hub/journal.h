/* The journal stores the last frames of the bus in the order in which all clients receive them. Each client reads at
 * its own pace, and is dropped if it falls more than JOURNAL_FRAMES behind. */
#ifndef COMANIP_HUB_JOURNAL_H
#define COMANIP_HUB_JOURNAL_H

#include <linux/can.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <time.h>

#define JOURNAL_FRAMES 65536u /* 3 s at 20,000 frames/s */

typedef struct {
    struct canfd_frame frame; /* or a struct can_frame, which begins in the same way */
    size_t bytes;             /* CAN_MTU or CANFD_MTU */
    uint32_t sender;          /* the sending client's number */
    struct timespec time;     /* time of reception by the hub, CLOCK_REALTIME */
} journal_entry_t;

typedef struct {
    journal_entry_t entry[JOURNAL_FRAMES];
    uint64_t end; /* number of frames appended so far */
} journal_t;

/* Returns true if the packet is a frame: its size is right, its length is valid, and its id has at most 11 bits unless
 * it is flagged as extended. */
bool journal_accepts(const void *packet, size_t bytes);

/* Appends a copy of a frame, for which journal_accepts() must be true. */
void journal_append(journal_t *self, const void *packet, size_t bytes, uint32_t sender, const struct timespec *time);

/* Returns false if the frame at the position has been overwritten. */
bool journal_has(const journal_t *self, uint64_t position);

/* Returns the frame at the position, for which journal_has() must be true. */
const journal_entry_t *journal_at(const journal_t *self, uint64_t position);

#endif
