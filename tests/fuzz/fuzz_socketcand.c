#include <sys/socket.h>

#include "../../host_tools/hub/socketcand_endpoint.h"
#include "fuzz_hub.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_hub(&socketcand_endpoint, SOCK_STREAM, data, size);
    return 0;
}
