/* Runs a hub with one client on the endpoint under test and one listener, all in this process. */
#ifndef COMANIP_FUZZ_HUB_H
#define COMANIP_FUZZ_HUB_H

#include <stddef.h>
#include <stdint.h>

#include "../../host_tools/hub/hub.h"

/* Splits the data into parts, sends each from the client, reads all answers, checks each frame that the listener
 * receives, and ends the hub. The byte before each part selects its length, mostly 16 or 72, which are the lengths
 * of frames. */
void fuzz_hub(const endpoint_t *endpoint, int socket_type, const uint8_t *data, size_t size);

#endif
