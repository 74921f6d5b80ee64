#include "can_hub.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

_Static_assert(CAN_SOCKET_PATH_BYTES == sizeof(((struct sockaddr_un *)NULL)->sun_path), "sockaddr_un has other paths");

int can_hub_connect(const char *path) {
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    memcpy(address.sun_path, path, strlen(path)); /* fits: can_hub_open() made the path */
    const int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd >= 0 && connect(fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        const int cause = errno;
        (void)close(fd);
        errno = cause;
        return -1;
    }
    return fd;
}

/* A folder in /tmp can be made by anybody: only our own hub, or root's, is listened to. */
static bool is_trusted(const char *path) {
    struct stat status;
    return stat(path, &status) != 0 || status.st_uid == getuid() || status.st_uid == 0;
}

int can_hub_open(const char *name, char path[CAN_SOCKET_PATH_BYTES], char error[], size_t error_size) {
    const char *folder = getenv("COMANIP_HUB_DIR");
    const bool is_set = folder != NULL && folder[0] != '\0';
    const int length = is_set ? snprintf(path, CAN_SOCKET_PATH_BYTES, "%s/%s", folder, name)
                              : snprintf(path, CAN_SOCKET_PATH_BYTES, "/tmp/comanip-hub-%u/%s", getuid(), name);
    if (length >= CAN_SOCKET_PATH_BYTES) {
        (void)snprintf(error, error_size, "COMANIP_HUB_DIR '%.200s': expected a path of less than %d bytes", folder,
                       CAN_SOCKET_PATH_BYTES - (int)strlen(name) - 1);
        return -1;
    }
    if (!is_trusted(path)) {
        (void)snprintf(error, error_size, "%s: the hub %s belongs to another user", name, path);
        return -1;
    }
    const int fd = can_hub_connect(path);
    if (fd < 0) {
        (void)snprintf(error, error_size, "%s: no such CAN interface in the kernel, and no hub at %s (%s): start one, or "
                       "as root: ip link add dev %s type vcan; ip link set %s mtu 72 up", name, path, strerror(errno),
                       name, name);
    }
    return fd;
}
