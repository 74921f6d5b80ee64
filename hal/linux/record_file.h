/* A small file that, even if a write is interrupted, holds either the previous content or the new one. */
#ifndef COMANIP_RECORD_FILE_H
#define COMANIP_RECORD_FILE_H

#include <stdbool.h>
#include <stddef.h>

typedef enum {
    RECORD_FILE_READ,
    RECORD_FILE_MISSING, /* the file is missing, but its folder exists */
    RECORD_FILE_FAILED,  /* failed, with errno */
} record_file_status_t;

/* Reads up to `capacity` bytes of the file. */
record_file_status_t record_file_read(const char *path, void *bytes, size_t capacity, size_t *length);

/* Writes FILE.tmp next to the file and renames it. File and folder are on the disk when this returns. On failure,
 * returns false with errno, and the file is unchanged. However, if only the folder could not be synchronised, the file
 * already has the new content. */
bool record_file_write(const char *path, const void *bytes, size_t length);

#endif
