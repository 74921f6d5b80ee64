#include "output_folder.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *const file_name[OUTPUT_COUNT] = {
    [OUTPUT_SUMMARY] = "summary.json",
    [OUTPUT_BUS_LOG] = "bus.log",
    [OUTPUT_TRACE] = "trace.csv",
};

static bool fail(char error[], size_t error_size, const char *path, const char *what) {
    (void)snprintf(error, error_size, "%s: %s: %s", path, what, strerror(errno));
    return false;
}

/* Returns NULL if out of memory. */
static char *join(const char *folder, const char *name, const char *suffix) {
    const size_t size = strlen(folder) + strlen(name) + strlen(suffix) + 2;
    char *path = malloc(size);
    if (path != NULL) {
        (void)snprintf(path, size, "%s/%s%s", folder, name, suffix);
    }
    return path;
}

/* Creates the folder and its parents, like mkdir -p. Modifies `path` temporarily. */
static bool make_folders(char *path, char error[], size_t error_size) {
    for (char *end = path + 1;; end++) {
        if (*end != '/' && *end != '\0') {
            continue;
        }
        const char kept = *end;
        *end = '\0';
        const bool made = mkdir(path, 0777) == 0 || errno == EEXIST;
        if (!made) {
            return fail(error, error_size, path, "cannot be created");
        }
        *end = kept;
        if (kept == '\0') {
            break;
        }
    }
    return true;
}

static bool is_folder(const char *path) {
    struct stat status;
    return stat(path, &status) == 0 && S_ISDIR(status.st_mode);
}

/* Checks that a file can be written at partial_path and can later be renamed to `path`. Creates or empties the file at
 * partial_path. */
static bool try_file(const char *path, const char *partial_path, char error[], size_t error_size) {
    if (is_folder(path)) {
        errno = EISDIR;
        return fail(error, error_size, path, "cannot be replaced by a file");
    }
    FILE *file = fopen(partial_path, "w");
    if (file == NULL || fclose(file) != 0) {
        return fail(error, error_size, partial_path, "cannot be written");
    }
    return true;
}

/* Locks the folder against other runs. The kernel releases the lock when the process ends, even if it crashes. On a
 * file system that does not support locks, the folder is used without a lock. */
static bool lock_folder(output_folder_t *self, const char *folder, char error[], size_t error_size) {
    self->lock = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (self->lock >= 0 && flock(self->lock, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        (void)snprintf(error, error_size, "%s: is in use by another run", folder);
        return false;
    }
    return true;
}

static bool ends_with(const char *name, const char *end) {
    const size_t length = strlen(name), end_length = strlen(end);
    return length >= end_length && strcmp(name + length - end_length, end) == 0;
}

/* Removes the plots of an earlier run from the subfolder `report`, and leaves all other files. */
static bool remove_report(const char *folder, char error[], size_t error_size) {
    char *path = join(folder, "report", "");
    /* If `report` is a symbolic link, it is not followed, because its target does not belong to this run. */
    const int opened = path != NULL ? open(path, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC) : -1;
    DIR *report = opened >= 0 ? fdopendir(opened) : NULL;
    bool removed = true;
    for (struct dirent *entry; removed && report != NULL && (entry = readdir(report)) != NULL;) {
        if (ends_with(entry->d_name, ".png")) {
            removed = unlinkat(opened, entry->d_name, 0) == 0 || fail(error, error_size, path, "cannot be emptied");
        }
    }
    if (report != NULL) {
        (void)closedir(report);
    } else if (opened >= 0) {
        (void)close(opened);
    }
    free(path);
    return removed;
}

bool output_folder_open(output_folder_t *self, const char *folder, char error[], size_t error_size) {
    memset(self, 0, sizeof *self);
    self->lock = -1;
    char *path = join(folder, "", "");
    const bool made =
        path != NULL ? make_folders(path, error, error_size) : fail(error, error_size, folder, "cannot be created");
    free(path);
    if (!made) {
        return false;
    }
    if (!is_folder(folder)) {
        errno = ENOTDIR;
        return fail(error, error_size, folder, "cannot be used as a folder");
    }
    if (!lock_folder(self, folder, error, error_size)) {
        return false; /* no paths are set yet, so output_folder_free() keeps the other run's files */
    }
    for (int i = 0; i < OUTPUT_COUNT; i++) {
        self->path[i] = join(folder, file_name[i], "");
        self->partial_path[i] = join(folder, file_name[i], ".partial");
        if (self->path[i] == NULL || self->partial_path[i] == NULL) {
            return fail(error, error_size, folder, "not enough memory");
        }
    }
    /* Check that all files can be written before removing any file of an earlier run. */
    for (int i = 0; i < OUTPUT_COUNT; i++) {
        if (!try_file(self->path[i], self->partial_path[i], error, error_size)) {
            return false;
        }
    }
    for (int i = 0; i < OUTPUT_COUNT; i++) {
        if (unlink(self->path[i]) != 0 && errno != ENOENT) {
            return fail(error, error_size, self->path[i], "cannot be replaced");
        }
    }
    return remove_report(folder, error, error_size);
}

bool output_folder_commit(output_folder_t *self, char error[], size_t error_size) {
    /* The summary is renamed last, so that a folder with a summary has all other files as well. */
    for (int i = OUTPUT_COUNT - 1; i >= 0; i--) {
        if (rename(self->partial_path[i], self->path[i]) != 0) {
            return fail(error, error_size, self->path[i], "cannot be renamed to its final name");
        }
    }
    return true;
}

void output_folder_free(output_folder_t *self) {
    for (int i = 0; i < OUTPUT_COUNT; i++) {
        if (self->partial_path[i] != NULL) {
            (void)unlink(self->partial_path[i]); /* does not exist after a commit */
        }
        free(self->path[i]);
        free(self->partial_path[i]);
    }
    if (self->lock >= 0) {
        (void)close(self->lock);
    }
}
