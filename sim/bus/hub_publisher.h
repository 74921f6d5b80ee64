/* Publishes the frames of the simulated bus on a hub as they happen. It never receives. A hub that is slow or gone
 * delays the run once, by at most SEND_TIMEOUT_MS. */
#ifndef COMANIP_SIM_HUB_PUBLISHER_H
#define COMANIP_SIM_HUB_PUBLISHER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "bus.h"

typedef struct {
    int fd;            /* -1: not connected */
    pid_t hub;         /* 0: not started by this program */
    bool is_exclusive; /* no other client of the hub can send */
    uint64_t lost;     /* frames not published since the hub was lost */
} hub_publisher_t;

/* Connects to the hub of this name, or starts one that ends with this program. Returns false on failure, with one line
 * in `error`. */
bool hub_publisher_open(hub_publisher_t *self, const char *bus, char error[], size_t error_size);

/* For bus_listen(); context is the hub_publisher_t. */
void hub_publisher_send(void *context, const can_frame_t *frame, int64_t end_ns);

/* Ends the hub if this program started it, after all listeners have received what was sent. */
void hub_publisher_close(hub_publisher_t *self);

#endif
