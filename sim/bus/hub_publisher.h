/* Publishes each frame of the simulated bus on a hub as soon as it has been sent. Never receives. If the hub stops
 * responding, the run waits once, for at most 1 s, and then continues without the hub. */
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
    uint64_t lost;     /* frames not published since the connection was lost */
} hub_publisher_t;

/* Connects to the hub of this name, or starts a hub that ends with this program. Returns false on failure, with one
 * line in `error`. */
bool hub_publisher_open(hub_publisher_t *self, const char *bus, char error[], size_t error_size);

/* Handler for bus_listen(). context: the hub_publisher_t. */
void hub_publisher_send(void *context, const can_frame_t *frame, int64_t end_ns);

/* Closes the connection. If this program started the hub, also stops the hub, which first sends the remaining frames to
 * its clients. */
void hub_publisher_close(hub_publisher_t *self);

#endif
