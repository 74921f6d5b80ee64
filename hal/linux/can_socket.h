/* A CAN bus for a Linux process: the kernel's SocketCAN if it has the interface, else a hub (AF_UNIX,
 * SOCK_SEQPACKET) of the same name that carries the same structures. CAN FD frames with bit-rate switch and classic
 * ones are sent; both are received, with 11-bit ids. Never blocks. One thread. */
#ifndef COMANIP_CAN_SOCKET_H
#define COMANIP_CAN_SOCKET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "../../firmware/protocol/can_frame.h"
#include "../../firmware/protocol/port_status.h"
#include "can_counters.h"
#include "can_selection.h"
#include "hub_path.h"

#define CAN_SOCKET_NAME_BYTES 16 /* IFNAMSIZ */

typedef struct {
    const char *program; /* its name, for reports on stderr */
    char name[CAN_SOCKET_NAME_BYTES];
    char hub_path[HUB_PATH_BYTES]; /* "": the kernel's interface */
    int fd;                        /* for poll(); negative: the hub is gone */
    bool lost;                     /* reported, and not yet back */
    uint32_t kernel_drops;         /* the kernel's count, as last seen */
    int64_t retry_ns;              /* CLOCK_MONOTONIC: time of the next attempt to reach the hub */
    can_counters_t counters;
} can_socket_t;

typedef struct {
    int64_t unix_ns;     /* the kernel's time stamp of the frame (CLOCK_REALTIME); 0: a hub has none */
    int64_t hardware_ns; /* the controller's, on its own clock; 0: it has none */
    bool own;            /* sent by this socket */
} can_reception_t;

/* Reports on stdout which of the two it is. On failure false, and one line in `error` that names the bus and the
 * remedy. */
bool can_socket_open(can_socket_t *self, const char *program, const char *name, const can_selection_t *selection,
                     char error[], size_t error_size);

/* The oldest frame received; the caller sets its timestamp_us. Error frames are reported and counted, but not given. A
 * lost bus is reported once, and tried again. False: there is no frame. */
bool can_socket_receive(can_socket_t *self, can_frame_t *frame, can_reception_t *reception);

/* False: the frame is dropped, and counted. */
bool can_socket_send(can_socket_t *self, const can_frame_t *frame);

/* Fills in the faults of the bus. A hub itself reports neither error states nor lost frames: these stay unknown until
 * another node's error frame arrives through the hub, and then count error frames only. */
void can_socket_status(const can_socket_t *self, port_status_t *status);

void can_socket_close(can_socket_t *self);

/* Reports losses and faults of the bus on stderr, if there were any. */
void can_socket_report(const can_socket_t *self);

#endif
