#include "can_kernel.h"

#include <errno.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/errqueue.h>
#include <linux/net_tstamp.h>
#include <net/if.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define RECEIVE_BUFFER_BYTES (1 << 20) /* about 1000 frames, or 150 ms at full bus load */
#define FILTERS_MAX 64

bool can_kernel_has(const char *name) {
    const int fd = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
    if (fd < 0) {
        return false;
    }
    (void)close(fd);
    return if_nametoindex(name) != 0;
}

static int fail(int fd, const char *name, const char *what, char error[], size_t error_size) {
    (void)snprintf(error, error_size, "%s: %s: %s", name, what, strerror(errno));
    if (fd >= 0) {
        (void)close(fd);
    }
    return -1;
}

static bool set(int fd, int level, int option, int value) {
    return setsockopt(fd, level, option, &value, sizeof value) == 0;
}

static bool set_filters(int fd, const can_selection_t *selection) {
    struct can_filter filter[FILTERS_MAX];
    if (selection->count == 0) {
        return true;
    }
    if (selection->count > FILTERS_MAX) {
        errno = E2BIG;
        return false;
    }
    for (size_t i = 0; i < selection->count; i++) {
        filter[i] =
            (struct can_filter){.can_id = selection->ids[i], .can_mask = CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG};
    }
    return setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, filter, (socklen_t)(selection->count * sizeof filter[0])) == 0;
}

/* Requests the kernel's timestamps, which candump logs too, and those of the controller, if it provides any. */
static bool set_options(int fd, const can_selection_t *selection) {
    const can_err_mask_t errors =
        CAN_ERR_BUSOFF | CAN_ERR_RESTARTED | CAN_ERR_CRTL | CAN_ERR_TX_TIMEOUT | CAN_ERR_BUSERROR;
    const unsigned stamps = SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE | SOF_TIMESTAMPING_RX_HARDWARE |
                            SOF_TIMESTAMPING_RAW_HARDWARE;
    if (!set(fd, SOL_SOCKET, SO_RCVBUFFORCE, RECEIVE_BUFFER_BYTES)) {
        (void)set(fd, SOL_SOCKET, SO_RCVBUF, RECEIVE_BUFFER_BYTES); /* as large as an unprivileged process may set it */
    }
    return set(fd, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, 1) && set_filters(fd, selection) &&
           set(fd, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, selection->own) &&
           setsockopt(fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) == 0 &&
           set(fd, SOL_SOCKET, SO_TIMESTAMPING, (int)stamps) && set(fd, SOL_SOCKET, SO_RXQ_OVFL, 1);
}

int can_kernel_open(const char *name, const can_selection_t *selection, char error[], size_t error_size) {
    const int fd = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
    struct ifreq request = {0};
    memcpy(request.ifr_name, name, strlen(name)); /* fits, because can_socket_open() has checked its length */
    if (fd < 0 || ioctl(fd, SIOCGIFMTU, &request) != 0) {
        return fail(fd, name, "cannot be opened", error, error_size);
    }
    if (request.ifr_mtu < (int)CANFD_MTU && !selection->classic) {
        (void)snprintf(error, error_size,
                       "%s: MTU %d, expected %d: CAN FD is switched off (ip link set %s mtu 72; a real "
                       "controller: ip link set %s type can fd on; a bus without FD: --profile classic)",
                       name, request.ifr_mtu, (int)CANFD_MTU, name, name);
        (void)close(fd);
        return -1;
    }
    if (!set_options(fd, selection)) {
        return fail(fd, name, "the options of the socket cannot be set", error, error_size);
    }
    const struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex(name)};
    if (bind(fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        return fail(fd, name, "the socket cannot be bound to this interface", error, error_size);
    }
    return fd;
}

static int64_t ns_from(const struct timespec *time) {
    return (int64_t)time->tv_sec * 1000000000 + time->tv_nsec;
}

static void read_notes(struct msghdr *message, can_kernel_notes_t *notes) {
    *notes = (can_kernel_notes_t){.own = (message->msg_flags & MSG_CONFIRM) != 0};
    for (struct cmsghdr *control = CMSG_FIRSTHDR(message); control != NULL; control = CMSG_NXTHDR(message, control)) {
        if (control->cmsg_level != SOL_SOCKET) {
            continue;
        }
        if (control->cmsg_type == SO_TIMESTAMPING) {
            struct scm_timestamping stamps;
            memcpy(&stamps, CMSG_DATA(control), sizeof stamps);
            notes->unix_ns = ns_from(&stamps.ts[0]);
            notes->hardware_ns = ns_from(&stamps.ts[2]);
        } else if (control->cmsg_type == SO_RXQ_OVFL) {
            memcpy(&notes->drops, CMSG_DATA(control), sizeof notes->drops);
            notes->has_drops = true;
        }
    }
}

ssize_t can_kernel_receive(int fd, struct canfd_frame *packet, can_kernel_notes_t *notes) {
    union {
        struct cmsghdr header; /* aligns `bytes` */
        char bytes[CMSG_SPACE(sizeof(struct scm_timestamping)) + CMSG_SPACE(sizeof(uint32_t))];
    } control;
    struct iovec data = {.iov_base = packet, .iov_len = sizeof *packet};
    struct msghdr message = {
        .msg_iov = &data, .msg_iovlen = 1, .msg_control = control.bytes, .msg_controllen = sizeof control.bytes};
    const ssize_t bytes = recvmsg(fd, &message, 0);
    read_notes(&message, notes);
    return bytes >= 0 && (message.msg_flags & MSG_TRUNC) != 0 ? (ssize_t)sizeof *packet + 1 : bytes;
}
