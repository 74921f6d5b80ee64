/* The receive filter of a raw CAN socket, implemented as a classic BPF program. The kernel applies it before a frame is
 * queued, so that poll() and select() report only frames that pass the filter. */
#ifndef COMANIP_SHIM_RECEIVE_FILTER_H
#define COMANIP_SHIM_RECEIVE_FILTER_H

#include <linux/can.h>
#include <linux/can/raw.h>
#include <stdbool.h>

typedef struct {
    struct can_filter filter[CAN_RAW_FILTER_MAX];
    int count;             /* 0: no data frames pass */
    bool join;             /* true: a frame must match all filters; false: at least one */
    bool fd_frames;        /* CAN FD frames may pass as well */
    can_err_mask_t errors; /* classes of error frames that pass */
} receive_filter_t;

/* Initialises the filter of a new socket, so that it passes all data frames of classic CAN. */
void receive_filter_init(receive_filter_t *self);

/* Attaches the filter to the socket. Returns 0, or -1 with errno. */
int receive_filter_attach(const receive_filter_t *self, int fd);

#endif
