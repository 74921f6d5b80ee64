#include "hub_path.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#define NAME_CHARACTERS "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-"
#define NAME_MAX_CHARACTERS 15

_Static_assert(HUB_PATH_BYTES == sizeof(((struct sockaddr_un *)NULL)->sun_path), "expected the size of sun_path");

bool hub_name_is_valid(const char *name) {
    const size_t length = strlen(name);
    return length >= 1 && length <= NAME_MAX_CHARACTERS && strspn(name, NAME_CHARACTERS) == length;
}

bool hub_folder(char folder[HUB_PATH_BYTES], char error[], size_t error_size) {
    const char *set = getenv("COMANIP_HUB_DIR");
    const bool is_set = set != NULL && set[0] != '\0';
    const int length = is_set ? snprintf(folder, HUB_PATH_BYTES, "%s", set)
                              : snprintf(folder, HUB_PATH_BYTES, "/tmp/comanip-hub-%u", getuid());
    if (length >= HUB_PATH_BYTES) {
        (void)snprintf(error, error_size, "COMANIP_HUB_DIR '%.200s': expected fewer than %d bytes", set,
                       HUB_PATH_BYTES);
        return false;
    }
    return true;
}

bool hub_folder_is_trusted(const char *folder, char error[], size_t error_size) {
    struct stat status;
    if (lstat(folder, &status) != 0) {
        (void)snprintf(error, error_size, "%s: %s", folder, strerror(errno));
        return false;
    }
    const bool is_ours = S_ISDIR(status.st_mode) && (status.st_uid == getuid() || status.st_uid == 0);
    if (!is_ours || (status.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
        (void)snprintf(error, error_size, "%s: expected a folder of yours or of root that only its owner may write to",
                       folder);
        return false;
    }
    return true;
}

bool hub_path(char path[HUB_PATH_BYTES], const char *folder, const char *name, const char *suffix, char error[],
              size_t error_size) {
    if (!hub_name_is_valid(name)) {
        (void)snprintf(error, error_size, "bus '%.200s': expected 1 to %d letters, digits, '_' and '-', e.g. vcan0",
                       name, NAME_MAX_CHARACTERS);
        return false;
    }
    if (snprintf(path, HUB_PATH_BYTES, "%s/%s%s", folder, name, suffix) >= HUB_PATH_BYTES) {
        (void)snprintf(error, error_size, "%.200s/%s%s: expected a path of fewer than %d bytes", folder, name, suffix,
                       HUB_PATH_BYTES);
        return false;
    }
    return true;
}

int hub_connect(int fd, const char *path) {
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    memcpy(address.sun_path, path, strnlen(path, HUB_PATH_BYTES - 1));
    return connect(fd, (const struct sockaddr *)&address, sizeof address);
}

bool hub_connect_by_name(int fd, const char *name, const char *suffix, char error[], size_t error_size) {
    char folder[HUB_PATH_BYTES], path[HUB_PATH_BYTES];
    if (!hub_folder(folder, error, error_size) || !hub_folder_is_trusted(folder, error, error_size) ||
        !hub_path(path, folder, name, suffix, error, error_size)) {
        return false;
    }
    if (hub_connect(fd, path) != 0) {
        (void)snprintf(error, error_size, "%s: no hub answers: %s", path, strerror(errno));
        return false;
    }
    return true;
}
