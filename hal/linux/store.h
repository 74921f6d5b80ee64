/* The HAL's store on Linux: one file.
 *
 * It is written by a thread of its own at ordinary priority, for fsync() may take a second on an SD card: the loop
 * copies the record and goes on, and asks each tick whether it is over. */
#ifndef COMANIP_LINUX_STORE_H
#define COMANIP_LINUX_STORE_H

#include <stdbool.h>
#include <stddef.h>

/* Reads the file and says on stdout what it found; a file that is not there yet is none. Without this call the port has
 * no store. path must last. On failure, if it cannot be read or its folder is not there, false, and one line in
 * `error`. */
bool store_open(const char *program, const char *path, char error[], size_t error_size);

/* Starts the thread, if there is a store, with the caller's own scheduling. Panics if there is no thread to be had. */
void store_start(void);

#endif
