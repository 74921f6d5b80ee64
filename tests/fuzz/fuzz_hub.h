/* Runs a hub with one client on the endpoint under test and one listener, all in this process. */
#ifndef COMANIP_FUZZ_HUB_H
#define COMANIP_FUZZ_HUB_H

#include <stddef.h>
#include <stdint.h>

#include "../../host_tools/hub/hub.h"

/* Splits the data into parts. The client sends each part, and the listener sends a frame after it; then all answers are
 * read, and each frame that the listener receives is checked. Finally the hub is freed. The byte before each part
 * selects the part's length: a value below 128 selects 16 or 72 bytes, the lengths of frames. */
void fuzz_hub(const endpoint_t *endpoint, int socket_type, const uint8_t *data, size_t size);

#endif
