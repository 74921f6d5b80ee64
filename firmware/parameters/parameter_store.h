/* All parameters as one record for a port's non-volatile store (hal.h).
 *
 *    0  4  'C' 'M' 'N' '2'
 *    4  1  how many parameters follow
 *    5  5  for each: its number, and its value as a float32
 *   -4  4  CRC-32 of all that precedes it
 *
 * Little-endian. CRC-32 is that of IEEE 802.3 (zlib's crc32): it detects every error of up to 3 bits in so short a
 * record. A parameter is stored under its number, which is never reused: parameters may be added and removed.
 *
 * Records of the former format, 'C' 'M' 'N' 'P', are read as well: the CRC-32 of the parameters' names, then the values
 * of parameters 0 to 37, or up to 42, and the CRC-32. */
#ifndef COMANIP_PARAMETER_STORE_H
#define COMANIP_PARAMETER_STORE_H

#include <stddef.h>

#include "parameters.h"

#define PARAMETER_STORE_RECORD_BYTES(count) (9 + 5 * (count))
#define PARAMETER_STORE_BYTES PARAMETER_STORE_RECORD_BYTES(PARAMETER_COUNT) /* at most, of this firmware's record */
#define PARAMETER_STORE_MAX_BYTES PARAMETER_STORE_RECORD_BYTES(PARAMETER_NUMBERS) /* of any firmware's */

/* Returns the record's length. */
size_t parameter_store_encode(const parameters_t *parameters, uint8_t record[PARAMETER_STORE_BYTES]);

/* All or nothing: false, and *parameters unchanged, unless the record is whole and parameters_set() takes each value of
 * a parameter that this firmware has. Other parameters' values are skipped; what the record lacks gets its default. */
bool parameter_store_decode(const uint8_t record[], size_t length, parameters_t *parameters);

#endif
