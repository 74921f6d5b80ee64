/* All parameters as one record for a port's non-volatile store (hal.h). Offset, length and content of the fields:
 *
 *    0  4  'C' 'M' 'N' '2'
 *    4  1  number of parameters that follow
 *    5  5  for each parameter: its number, and its value as a float32
 *   -4  4  CRC-32 of all preceding bytes
 *
 * Little-endian. The CRC-32 is that of IEEE 802.3 (zlib's crc32), which detects every error of up to 3 bits in so short
 * a record. A parameter is stored under its number, which is never reused, so that parameters may be added and removed.
 *
 * Records of the former format are read as well. They hold 'C' 'M' 'N' 'P', the CRC-32 of the parameters' names, the
 * values of parameters 0 to N, where N is 37 to 42, and the CRC-32 of all preceding bytes. */
#ifndef COMANIP_PARAMETER_STORE_H
#define COMANIP_PARAMETER_STORE_H

#include <stddef.h>

#include "parameters.h"

#define PARAMETER_STORE_RECORD_BYTES(count) (9 + 5 * (count))
#define PARAMETER_STORE_BYTES PARAMETER_STORE_RECORD_BYTES(PARAMETER_COUNT)       /* largest record of this firmware */
#define PARAMETER_STORE_MAX_BYTES PARAMETER_STORE_RECORD_BYTES(PARAMETER_NUMBERS) /* largest record of any firmware */

/* Writes the record and returns its length. */
size_t parameter_store_encode(const parameters_t *parameters, uint8_t record[PARAMETER_STORE_BYTES]);

/* Reads the record. Returns false and leaves *parameters unchanged if the record is damaged or a value is out of range.
 * Skips values of parameters that this firmware does not have, and sets parameters missing from the record to their
 * defaults. */
bool parameter_store_decode(const uint8_t record[], size_t length, parameters_t *parameters);

#endif
