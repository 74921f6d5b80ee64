/* Emulates raw CAN sockets with connections to a hub: see can_socket.h. */
#include "can_socket.h"

#include <errno.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "../../hal/linux/hub_path.h"
#include "interface_names.h"

#define DESCRIPTORS 1024
#define ERROR_BYTES 512

static _Atomic(can_socket_t *) table[DESCRIPTORS]; /* indexed by descriptor */

int can_socket_adopt(int fd) {
    struct stat status;
    can_socket_t *self = fd >= 0 && fd < DESCRIPTORS && fstat(fd, &status) == 0 ? calloc(1, sizeof *self) : NULL;
    if (self == NULL) {
        if (fd >= 0) {
            (void)close(fd);
            errno = EMFILE;
        }
        return -1;
    }
    *self = (can_socket_t){.fd = fd, .device = status.st_dev, .inode = status.st_ino, .loopback = true, .sender = -1};
    receive_filter_init(&self->filter);
    free(atomic_exchange(&table[fd], self)); /* an old entry remains if a socket was not closed through close() */
    return fd;
}

can_socket_t *can_socket_find(int fd) {
    can_socket_t *self = fd >= 0 && fd < DESCRIPTORS ? atomic_load(&table[fd]) : NULL;
    if (self == NULL) {
        return NULL;
    }
    struct stat status;
    const int cause = errno;
    const bool is_same = fstat(fd, &status) == 0 && status.st_dev == self->device && status.st_ino == self->inode;
    errno = cause;
    return is_same ? self : NULL;
}

void can_socket_forget(can_socket_t *self) {
    if (self->sender >= 0) {
        (void)close(self->sender);
    }
    atomic_store(&table[self->fd], NULL);
    free(self);
}

static bool connect_to(int fd, unsigned index) {
    char error[ERROR_BYTES];
    const char *name = interface_name(index);
    if (name == NULL || !hub_connect_by_name(fd, name, "", error, sizeof error)) {
        errno = ENODEV;
        return false;
    }
    return true;
}

int can_socket_bind(can_socket_t *self, unsigned index) {
    const bool is_any = index == 0;
    const bool receives_nothing = self->filter.count == 0 && self->filter.errors == 0;
    if (self->is_bound) {
        errno = EINVAL;
        return -1;
    }
    index = is_any ? interface_only() : index;
    if (index != 0 || !is_any || !receives_nothing) { /* else no connection is needed: each frame names its interface */
        if (receive_filter_attach(&self->filter, self->fd) != 0 || !connect_to(self->fd, index)) {
            return -1;
        }
        self->index = index;
    }
    self->is_bound = true;
    return 0;
}

int can_socket_route(can_socket_t *self, unsigned index) {
    index = index == 0 ? self->index : index;
    if (index == 0) {
        errno = ENXIO;
        return -1;
    }
    if (index == self->index && !self->receives_own) {
        return self->fd;
    }
    if (self->sender < 0 || self->sender_index != index) {
        const int sender = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
        if (sender < 0 || !connect_to(sender, index)) {
            const int cause = errno;
            if (sender >= 0) {
                (void)close(sender);
            }
            errno = cause;
            return -1;
        }
        (void)shutdown(sender, SHUT_RD);
        if (self->sender >= 0) {
            (void)close(self->sender);
        }
        self->sender = sender;
        self->sender_index = index;
    }
    return self->sender;
}

static int set_filters(receive_filter_t *self, const void *value, socklen_t length) {
    if (length % sizeof self->filter[0] != 0 || length > sizeof self->filter) {
        errno = EINVAL;
        return -1;
    }
    if (length > 0) {
        memcpy(self->filter, value, length);
    }
    self->count = (int)(length / sizeof self->filter[0]);
    return 0;
}

/* Returns the flag that this option sets, or NULL if the option is not a flag. */
static bool *find_flag(can_socket_t *self, int name) {
    return name == CAN_RAW_LOOPBACK        ? &self->loopback
           : name == CAN_RAW_RECV_OWN_MSGS ? &self->receives_own
           : name == CAN_RAW_FD_FRAMES     ? &self->filter.fd_frames
           : name == CAN_RAW_JOIN_FILTERS  ? &self->filter.join
                                           : NULL;
}

int can_socket_set_option(can_socket_t *self, int name, const void *value, socklen_t length) {
    bool *flag = find_flag(self, name);
    int number = 0;
    if (name == CAN_RAW_FILTER) {
        if (set_filters(&self->filter, value, length) != 0) {
            return -1;
        }
    } else if (flag != NULL || name == CAN_RAW_ERR_FILTER) {
        if (length != sizeof number) {
            errno = EINVAL;
            return -1;
        }
        memcpy(&number, value, sizeof number);
        if (flag != NULL) {
            *flag = number != 0;
        } else {
            self->filter.errors = (can_err_mask_t)number & CAN_ERR_MASK;
        }
    } else {
        errno = ENOPROTOOPT;
        return -1;
    }
    return self->index != 0 ? receive_filter_attach(&self->filter, self->fd) : 0;
}

int can_socket_get_option(const can_socket_t *self, int name, void *value, socklen_t *length) {
    can_socket_t copy = *self; /* writable, as find_flag() requires */
    const bool *flag = find_flag(&copy, name);
    const int number = flag != NULL ? *flag : (int)self->filter.errors;
    const void *from = name == CAN_RAW_FILTER ? (const void *)self->filter.filter : &number;
    const size_t bytes =
        name == CAN_RAW_FILTER ? (size_t)self->filter.count * sizeof self->filter.filter[0] : sizeof number;
    if (flag == NULL && name != CAN_RAW_FILTER && name != CAN_RAW_ERR_FILTER) {
        errno = ENOPROTOOPT;
        return -1;
    }
    if (*length < bytes) {
        errno = ERANGE;
        return -1;
    }
    memcpy(value, from, bytes);
    *length = (socklen_t)bytes;
    return 0;
}
