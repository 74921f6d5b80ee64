/* The HAL's store on Linux, which is one file.
 *
 * A separate thread of ordinary priority writes the file, since fsync() can take a second on an SD card. The firmware's
 * loop copies the record, continues, and polls the status in each tick. */
#ifndef COMANIP_LINUX_STORE_H
#define COMANIP_LINUX_STORE_H

#include <stdbool.h>
#include <stddef.h>

/* Reads the file and reports on stdout what it found; a missing file is not an error. Without this call, the port has
 * no store. path must remain valid. If the file cannot be read or its folder is missing, returns false and one line in
 * `error`. */
bool store_open(const char *program, const char *path, char error[], size_t error_size);

/* Starts the thread, if there is a store, with the caller's scheduling policy and priority. Panics if the thread cannot
 * be created. */
void store_start(void);

#endif
