#include "can_hub.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

int can_hub_connect(const char *path) {
    const int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd >= 0 && hub_connect(fd, path) != 0) {
        const int cause = errno;
        (void)close(fd);
        errno = cause;
        return -1;
    }
    return fd;
}

int can_hub_open(const char *name, char path[HUB_PATH_BYTES], char error[], size_t error_size) {
    char folder[HUB_PATH_BYTES];
    if (!hub_folder(folder, error, error_size) || !hub_path(path, folder, name, "", error, error_size)) {
        return -1;
    }
    const bool is_there = access(path, F_OK) == 0;
    if (is_there && !hub_folder_is_trusted(folder, error, error_size)) {
        return -1;
    }
    const int fd = can_hub_connect(path);
    if (fd < 0) {
        (void)snprintf(error, error_size,
                       "%s: no such CAN interface in the kernel, and no hub at %s (%s): start a hub (make hub CAN=%s), "
                       "or as root: ip link add dev %s type vcan; ip link set %s mtu 72 up",
                       name, path, strerror(errno), name, name, name);
    }
    return fd;
}
