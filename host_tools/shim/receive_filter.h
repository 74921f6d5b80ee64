/* What a raw CAN socket wants to receive, as a classic BPF program: the kernel applies it before a frame is queued, so
 * that poll() and select() tell of wanted frames only. */
#ifndef COMANIP_SHIM_RECEIVE_FILTER_H
#define COMANIP_SHIM_RECEIVE_FILTER_H

#include <linux/can.h>
#include <linux/can/raw.h>
#include <stdbool.h>

typedef struct {
    struct can_filter filter[CAN_RAW_FILTER_MAX];
    int count;             /* 0: no data frames at all */
    bool join;             /* all filters must match, not any */
    bool fd_frames;        /* CAN FD as well */
    can_err_mask_t errors; /* classes of error frames */
} receive_filter_t;

/* All data frames of classic CAN, as a new socket. */
void receive_filter_init(receive_filter_t *self);

/* Gives 0, or -1 with errno. */
int receive_filter_attach(const receive_filter_t *self, int fd);

#endif
