/* A hub with one client of the kind under test, and one that listens, both in this process. */
#ifndef COMANIP_FUZZ_HUB_H
#define COMANIP_FUZZ_HUB_H

#include <stddef.h>
#include <stdint.h>

#include "../../host_tools/hub/hub.h"

/* Lets the client send each part, reads all answers, checks each frame that the listener gets, and ends the hub. A byte
 * before each part says how long it is: 16 and 72, as frames are, come often. */
void fuzz_hub(const endpoint_t *endpoint, int socket_type, const uint8_t *data, size_t size);

#endif
