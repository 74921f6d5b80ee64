#include "record_file.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define SUFFIX ".tmp"

/* Closes the file and preserves errno. */
static void close_quietly(int fd) {
    const int cause = errno;
    (void)close(fd);
    errno = cause;
}

static int open_folder(const char *path) {
    char folder[PATH_MAX];
    const char *slash = strrchr(path, '/');
    const size_t length = slash == NULL ? 0 : (size_t)(slash - path) + 1; /* including the slash, for a file in / */
    if (length >= sizeof folder) {
        errno = ENAMETOOLONG;
        return -1;
    }
    memcpy(folder, path, length);
    folder[length] = '\0';
    return open(length == 0 ? "." : folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
}

record_file_status_t record_file_read(const char *path, void *bytes, size_t capacity, size_t *length) {
    *length = 0;
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0) {
        const int folder = errno == ENOENT ? open_folder(path) : -1;
        if (folder < 0) {
            return RECORD_FILE_FAILED;
        }
        (void)close(folder);
        return RECORD_FILE_MISSING;
    }
    ssize_t count;
    while ((count = read(fd, (char *)bytes + *length, capacity - *length)) > 0) {
        *length += (size_t)count;
    }
    close_quietly(fd);
    return count == 0 ? RECORD_FILE_READ : RECORD_FILE_FAILED;
}

static bool write_all(int fd, const char *bytes, size_t length) {
    for (size_t done = 0; done < length;) {
        const ssize_t count = write(fd, bytes + done, length - done);
        if (count < 0 && errno != EINTR) {
            return false;
        }
        done += count > 0 ? (size_t)count : 0;
    }
    return true;
}

static bool write_temporary(const char *path, const void *bytes, size_t length) {
    const int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (fd < 0) {
        return false;
    }
    const bool is_written = write_all(fd, bytes, length) && fsync(fd) == 0;
    close_quietly(fd);
    return is_written;
}

static bool sync_folder(const char *path) {
    const int fd = open_folder(path);
    if (fd < 0) {
        return false;
    }
    const bool is_synchronised = fsync(fd) == 0;
    close_quietly(fd);
    return is_synchronised;
}

bool record_file_write(const char *path, const void *bytes, size_t length) {
    char temporary[PATH_MAX];
    if (snprintf(temporary, sizeof temporary, "%s" SUFFIX, path) >= (int)sizeof temporary) {
        errno = ENAMETOOLONG;
        return false;
    }
    if (!write_temporary(temporary, bytes, length) || rename(temporary, path) != 0) {
        const int cause = errno;
        (void)unlink(temporary);
        errno = cause;
        return false;
    }
    return sync_folder(path);
}
