/* The HAL's store functions for ports without a store. */
#include "../hal.h"

bool hal_store_read(void *bytes, size_t capacity, size_t *length) {
    (void)bytes;
    (void)capacity;
    *length = 0;
    return false;
}

void hal_store_write(const void *bytes, size_t length) {
    (void)bytes;
    (void)length;
}

hal_store_status_t hal_store_status(void) {
    return HAL_STORE_NONE;
}
