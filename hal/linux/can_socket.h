/* A CAN bus for a Linux process. It uses the kernel's SocketCAN if the kernel has the interface; otherwise, it uses the
 * hub (AF_UNIX, SOCK_SEQPACKET) of the same name, which carries the same structures. It sends and receives classic
 * frames and CAN FD frames (sent with bit-rate switch), all with 11-bit ids. It never blocks, and must be used by one
 * thread only. */
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
    const char *program; /* name of the program, for reports on stderr */
    char name[CAN_SOCKET_NAME_BYTES];
    char hub_path[HUB_PATH_BYTES]; /* empty for the kernel's interface */
    int fd;                        /* file descriptor for poll(); negative while the hub is gone */
    bool lost;                     /* the loss has been reported, and the bus is not yet back */
    uint32_t kernel_drops;         /* last value of the kernel's count of dropped frames */
    int64_t retry_ns;              /* time of the next attempt to reach the hub, by CLOCK_MONOTONIC */
    can_counters_t counters;
} can_socket_t;

typedef struct {
    int64_t unix_ns;     /* the kernel's timestamp of the frame (CLOCK_REALTIME); 0 from a hub, which provides none */
    int64_t hardware_ns; /* the controller's timestamp, by its own clock; 0 if it provides none */
    bool own;            /* the frame was sent by this socket */
} can_reception_t;

/* Opens the bus, and reports on stdout whether it is an interface or a hub. On failure, returns false and one line in
 * `error` that names the bus and the remedy. */
bool can_socket_open(can_socket_t *self, const char *program, const char *name, const can_selection_t *selection,
                     char error[], size_t error_size);

/* Returns the oldest received frame; the caller must set its timestamp_us. Error frames are not returned, but reported
 * and counted. The loss of the bus is reported once, and reconnecting is attempted. Returns false if there is no
 * frame. */
bool can_socket_receive(can_socket_t *self, can_frame_t *frame, can_reception_t *reception);

/* Sends a frame. If that is impossible, drops and counts the frame, and returns false. */
bool can_socket_send(can_socket_t *self, const can_frame_t *frame);

/* Fills in the faults of the bus. A hub itself reports neither error states nor lost frames. Both remain unknown until
 * an error frame from another node arrives through the hub; from then on, they are derived from error frames only. */
void can_socket_status(const can_socket_t *self, port_status_t *status);

void can_socket_close(can_socket_t *self);

/* Reports the losses and faults of the bus on stderr, if there were any. */
void can_socket_report(const can_socket_t *self);

#endif
