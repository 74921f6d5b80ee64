/* The last frames of the bus, in the order that all clients see. Each client reads at its own pace. A client has lost
 * frames if it is more than JOURNAL_FRAMES behind. */
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
    struct timespec time;     /* when the hub received it; CLOCK_REALTIME */
} journal_entry_t;

typedef struct {
    journal_entry_t entry[JOURNAL_FRAMES];
    uint64_t end; /* number of frames appended so far */
} journal_t;

/* True if the packet is one frame: it has the right size, a valid length, and an id of 11 bits unless it is flagged as
 * extended. */
bool journal_accepts(const void *packet, size_t bytes);

/* Copies a frame that journal_accepts(). */
void journal_append(journal_t *self, const void *packet, size_t bytes, uint32_t sender, const struct timespec *time);

/* False if the frame at the position was overwritten. */
bool journal_has(const journal_t *self, uint64_t position);

/* The frame at the position, for which journal_has() must be true. */
const journal_entry_t *journal_at(const journal_t *self, uint64_t position);

#endif
