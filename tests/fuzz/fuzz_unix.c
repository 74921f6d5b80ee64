#include <sys/socket.h>

#include "../../host_tools/hub/unix_endpoint.h"
#include "fuzz_hub.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_hub(&unix_endpoint, SOCK_SEQPACKET, data, size);
    return 0;
}
