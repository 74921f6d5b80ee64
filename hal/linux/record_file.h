/* A small file that holds, after any interruption, either the previous content or the new one. */
#ifndef COMANIP_RECORD_FILE_H
#define COMANIP_RECORD_FILE_H

#include <stdbool.h>
#include <stddef.h>

typedef enum {
    RECORD_FILE_READ,
    RECORD_FILE_MISSING, /* but its folder is there */
    RECORD_FILE_FAILED,  /* with errno */
} record_file_status_t;

/* Up to `capacity` bytes of the file. */
record_file_status_t record_file_read(const char *path, void *bytes, size_t capacity, size_t *length);

/* Writes FILE.tmp next to the file and renames it; file and folder are on the disk when this returns. False, with
 * errno: the file is unchanged, or, if only the folder could not be synchronised, the new one. */
bool record_file_write(const char *path, const void *bytes, size_t length);

#endif
