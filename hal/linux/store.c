#include "store.h"

#include <errno.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "../hal.h"
#include "record_file.h"

#define RECORD_MAX_BYTES 4096

typedef struct {
    uint8_t bytes[RECORD_MAX_BYTES];
    size_t length;
} record_t;

static struct {
    const char *program;
    const char *path; /* path of the file; NULL if there is no store */
    bool has_record;
    record_t read, written; /* only the thread uses `written` while the status is HAL_STORE_WRITING */
    sem_t wanted;
    atomic_int status; /* hal_store_status_t */
} store;

bool store_open(const char *program, const char *path, char error[], size_t error_size) {
    const record_file_status_t found =
        record_file_read(path, store.read.bytes, sizeof store.read.bytes, &store.read.length);
    if (found == RECORD_FILE_FAILED) {
        (void)snprintf(error, error_size, "--parameters '%.300s': %s", path, strerror(errno));
        return false;
    }
    store.program = program;
    store.path = path;
    store.has_record = found == RECORD_FILE_READ;
    atomic_store(&store.status, HAL_STORE_WRITTEN);
    if (store.has_record) {
        (void)printf("%s: parameters read from %s, %zu bytes\n", program, path, store.read.length);
    } else {
        (void)printf("%s: %s does not exist yet: all parameters have their defaults\n", program, path);
    }
    (void)fflush(stdout);
    return true;
}

static void *write_records(void *unused) {
    (void)unused;
    for (;;) {
        while (sem_wait(&store.wanted) != 0) { /* interrupted by a signal */
        }
        const bool is_written = record_file_write(store.path, store.written.bytes, store.written.length);
        if (!is_written) {
            (void)fprintf(stderr, "%s: saving the parameters failed: %s: %s\n", store.program, store.path,
                          strerror(errno));
        }
        atomic_store(&store.status, is_written ? HAL_STORE_WRITTEN : HAL_STORE_FAILED);
    }
    return NULL;
}

void store_start(void) {
    pthread_t thread;
    if (store.path != NULL &&
        (sem_init(&store.wanted, 0, 0) != 0 || pthread_create(&thread, NULL, write_records, NULL) != 0 ||
         pthread_detach(thread) != 0)) {
        hal_panic("store: cannot create its thread");
    }
}

bool hal_store_read(void *bytes, size_t capacity, size_t *length) {
    *length = store.read.length < capacity ? store.read.length : capacity;
    memcpy(bytes, store.read.bytes, *length);
    return store.has_record;
}

void hal_store_write(const void *bytes, size_t length) {
    if (store.path == NULL) {
        return;
    }
    if (length > RECORD_MAX_BYTES) {
        atomic_store(&store.status, HAL_STORE_FAILED);
        return;
    }
    store.written.length = length;
    memcpy(store.written.bytes, bytes, length);
    atomic_store(&store.status, HAL_STORE_WRITING);
    (void)sem_post(&store.wanted);
}

hal_store_status_t hal_store_status(void) {
    return (hal_store_status_t)atomic_load(&store.status);
}
