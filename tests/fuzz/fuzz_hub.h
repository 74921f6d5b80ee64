/* A hub with one client of the type under test and one listener, both in this process. */
#ifndef COMANIP_FUZZ_HUB_H
#define COMANIP_FUZZ_HUB_H

#include <stddef.h>
#include <stdint.h>

#include "../../host_tools/hub/hub.h"

/* Sends each part from the client, reads all answers, checks each frame received by the listener, and ends the hub. A
 * byte before each part gives its length; 16 and 72, the lengths of frames, are frequent. */
void fuzz_hub(const endpoint_t *endpoint, int socket_type, const uint8_t *data, size_t size);

#endif
