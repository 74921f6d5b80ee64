/* All parameters as one record for a port's non-volatile store (hal.h).
 *
 *   0  4  'C' 'M' 'N' 'P'
 *   4  4  layout: CRC-32 of the names of its parameters, each with the 0 that ends it. A firmware with other
 * parameters, or with the same in another order, has another one 8  4 for each parameter: float32 -4  4  CRC-32 of all
 * that stands before
 *
 * New parameters come last in parameter_table: a record that ends before them is an older firmware's, and is read.
 *
 * Little-endian. CRC-32 is that of IEEE 802.3 (zlib's crc32): it finds every error of up to 3 bits in so short a
 * record. */
#ifndef COMANIP_PARAMETER_STORE_H
#define COMANIP_PARAMETER_STORE_H

#include <stddef.h>

#include "parameters.h"

#define PARAMETER_STORE_BYTES (12 + 4 * PARAMETER_COUNT)

void parameter_store_encode(const parameters_t *parameters, uint8_t record[PARAMETER_STORE_BYTES]);

/* All or nothing: false, and *parameters as it was, unless the record is whole, its layout is this firmware's up to
 * where it ends, and each value is one that parameters_set() takes. What an older firmware's record lacks gets its
 * default. */
bool parameter_store_decode(const uint8_t record[], size_t length, parameters_t *parameters);

#endif
