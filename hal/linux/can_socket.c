#include "can_socket.h"

#include <errno.h>
#include <linux/can.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "can_errors.h"
#include "can_hub.h"
#include "can_kernel.h"

#define HUB_RETRY_NS INT64_C(10000000)

static int64_t monotonic_ns(void) {
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

bool can_socket_open(can_socket_t *self, const char *program, const char *name, const can_selection_t *selection,
                     char error[], size_t error_size) {
    *self = (can_socket_t){.program = program, .fd = -1};
    const size_t length = strlen(name);
    if (length == 0 || length >= sizeof self->name || strchr(name, '/') != NULL || name[0] == '.') {
        (void)snprintf(error, error_size, "'%.100s': expected the name of a CAN interface, for example vcan0", name);
        return false;
    }
    memcpy(self->name, name, length + 1);
    if (can_kernel_has(name)) {
        self->fd = can_kernel_open(name, selection, error, error_size);
    } else {
        self->fd = can_hub_open(name, self->hub_path, error, error_size);
    }
    if (self->fd < 0) {
        return false;
    }
    (void)printf("%s: %s is %s%s\n", program, name, self->hub_path[0] != '\0' ? "the hub " : "the kernel's interface",
                 self->hub_path);
    (void)fflush(stdout);
    return true;
}

/* ---- loss of the bus */

static void lose(can_socket_t *self, const char *why) {
    if (!self->lost) {
        self->lost = true;
        self->counters.losses++;
        (void)fprintf(stderr, "%s: %s: lost: %s\n", self->program, self->name, why);
    }
    if (self->hub_path[0] != '\0' && self->fd >= 0) { /* an interface's socket survives while the interface is down */
        (void)close(self->fd);
        self->fd = -1;
    }
}

static void return_to_bus(can_socket_t *self) {
    if (self->lost) {
        self->lost = false;
        (void)fprintf(stderr, "%s: %s: back\n", self->program, self->name);
    }
}

/* Returns whether there is a socket, after trying to reconnect if there is none. */
static bool has_socket(can_socket_t *self) {
    if (self->fd < 0 && monotonic_ns() >= self->retry_ns) {
        self->retry_ns = monotonic_ns() + HUB_RETRY_NS;
        self->fd = can_hub_connect(self->hub_path);
        if (self->fd >= 0) {
            return_to_bus(self);
        }
    }
    return self->fd >= 0;
}

/* ---- receive */

static void count_kernel_drops(can_socket_t *self, uint32_t drops) {
    self->counters.receive_drops += (uint32_t)(drops - self->kernel_drops);
    self->kernel_drops = drops;
}

/* struct can_frame and struct canfd_frame share their first eight bytes and the offset of the data. */
static bool take(can_socket_t *self, const struct canfd_frame *packet, ssize_t bytes, can_frame_t *frame) {
    const bool is_classic = bytes == CAN_MTU && packet->len <= CAN_MAX_DLEN;
    const bool is_fd = bytes == CANFD_MTU && packet->len <= CANFD_MAX_DLEN;
    if (is_classic && (packet->can_id & CAN_ERR_FLAG) != 0) {
        can_errors_report(self->program, self->name, packet, &self->counters);
        return false;
    }
    if (!(is_classic || is_fd) || (packet->can_id & ~(canid_t)CAN_SFF_MASK) != 0) {
        self->counters.ignored++;
        return false;
    }
    *frame = (can_frame_t){.id = (uint16_t)packet->can_id, .length = packet->len, .fd = is_fd};
    memcpy(frame->data, packet->data, packet->len);
    self->counters.received++;
    return_to_bus(self);
    return true;
}

bool can_socket_receive(can_socket_t *self, can_frame_t *frame, can_reception_t *reception) {
    while (has_socket(self)) {
        struct canfd_frame packet;
        can_kernel_notes_t notes;
        const ssize_t bytes = can_kernel_receive(self->fd, &packet, &notes);
        if (bytes < 0 && (errno == EAGAIN || errno == EINTR)) {
            return false;
        }
        if (bytes < 0 || (bytes == 0 && self->hub_path[0] != '\0')) {
            lose(self, bytes < 0 ? strerror(errno) : "the hub closed the connection");
            continue;
        }
        if (notes.has_drops) {
            count_kernel_drops(self, notes.drops);
        }
        if (take(self, &packet, bytes, frame)) {
            *reception =
                (can_reception_t){.unix_ns = notes.unix_ns, .hardware_ns = notes.hardware_ns, .own = notes.own};
            return true;
        }
    }
    return false;
}

/* ---- send */

bool can_socket_send(can_socket_t *self, const can_frame_t *frame) {
    struct canfd_frame packet = {.can_id = frame->id, .len = frame->length, .flags = frame->fd ? CANFD_BRS : 0};
    const ssize_t size = frame->fd ? CANFD_MTU : CAN_MTU; /* the two structures share their first bytes */
    memcpy(packet.data, frame->data, frame->length);
    const ssize_t bytes = has_socket(self) ? send(self->fd, &packet, (size_t)size, MSG_NOSIGNAL) : -1;
    if (bytes == size) {
        self->counters.sent++;
        return_to_bus(self);
        return true;
    }
    const bool is_full = self->fd < 0 || errno == EAGAIN || errno == ENOBUFS || errno == EINTR;
    if (!is_full) {
        lose(self, strerror(errno));
    }
    self->counters.send_drops++;
    return false;
}

void can_socket_status(const can_socket_t *self, port_status_t *status) {
    status->refused_frames = port_count(self->counters.send_drops);
    if (self->hub_path[0] == '\0' || self->counters.error_frames > 0) { /* a hub may pass on error frames */
        status->can_state = self->counters.can_state;
        status->lost_frames = port_count(self->counters.receive_drops);
        status->error_passive = port_count(self->counters.error_passive);
        status->bus_off = port_count(self->counters.bus_offs);
    }
}

void can_socket_close(can_socket_t *self) {
    if (self->fd >= 0) {
        (void)close(self->fd);
        self->fd = -1;
    }
}

void can_socket_report(const can_socket_t *self) {
    const can_counters_t *counters = &self->counters;
    const struct {
        const char *what;
        uint64_t count;
    } table[] = {
        {"frames not sent", counters->send_drops},
        {"frames lost in the receive queue", counters->receive_drops},
        {"frames ignored (remote, 29-bit id or malformed)", counters->ignored},
        {"error frames", counters->error_frames},
        {"times error-passive", counters->error_passive},
        {"times bus-off", counters->bus_offs},
        {"restarts", counters->restarts},
        {"times without the bus", counters->losses},
    };
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        if (table[i].count > 0) {
            (void)fprintf(stderr, "%s: %s: %llu %s\n", self->program, self->name, (unsigned long long)table[i].count,
                          table[i].what);
        }
    }
}
