/* Shows the frames of the simulated bus to the listeners on a hub, as they happen. It only sends: nothing comes back,
 * and a hub that is slow or gone costs the run no more than PATIENCE_MS, once. */
#ifndef COMANIP_SIM_HUB_PUBLISHER_H
#define COMANIP_SIM_HUB_PUBLISHER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "bus.h"

typedef struct {
    int fd;            /* -1: the hub is gone */
    pid_t hub;         /* started by us; 0: it was there */
    bool is_exclusive; /* on the hub nobody else can send */
    uint64_t lost;     /* frames after the hub was gone */
} hub_publisher_t;

/* Connects to the hub of this name, or starts one, beside this program, that ends with it. On failure false, and one
 * line in `error`. */
bool hub_publisher_open(hub_publisher_t *self, const char *bus, char error[], size_t error_size);

/* For bus_listen(); context is the hub_publisher_t. */
void hub_publisher_send(void *context, const can_frame_t *frame, int64_t end_ns);

/* Ends the hub if we started it, after all listeners got what was sent. */
void hub_publisher_close(hub_publisher_t *self);

#endif
