#include "fuzz_hub.h"

#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "../../host_tools/hub/unix_endpoint.h"

#define BUFFER_BYTES 4096

/* Aborts unless the packet is a valid SocketCAN frame. The check shares no code with that of the hub. */
static void require_frame(const uint8_t *packet, ssize_t bytes) {
    canid_t id;
    memcpy(&id, packet, sizeof id);
    const int longest = bytes == 16 ? 8 : bytes == 72 ? 64 : -1;
    if (packet[4] > longest || ((id & 0xA0000000u) == 0 && (id & 0x1FFFFFFFu) > 0x7FFu)) {
        abort();
    }
}

static int add(hub_t *hub, const endpoint_t *endpoint, int socket_type) {
    int pair[2];
    if (socketpair(AF_UNIX, socket_type | SOCK_NONBLOCK, 0, pair) != 0 ||
        hub_add_client(hub, pair[1], endpoint, true) == NULL) {
        abort();
    }
    return pair[0];
}

void fuzz_hub(const endpoint_t *endpoint, int socket_type, const uint8_t *data, size_t size) {
    static hub_t hub;
    uint8_t buffer[BUFFER_BYTES];
    ssize_t bytes;
    if (!hub_init(&hub, "vcan0")) {
        return;
    }
    const int sender = add(&hub, endpoint, socket_type);
    const int listener = add(&hub, &unix_endpoint, SOCK_SEQPACKET);
    hub.settle_ms = 0;
    size_t part = 0;
    for (size_t at = 0; at + 1 < size; at += part + 1) {
        const size_t requested = data[at] < 64 ? 16 : data[at] < 128 ? 72 : (size_t)data[at] - 127;
        part = size - at - 1 < requested ? size - at - 1 : requested;
        (void)send(sender, data + at + 1, part, MSG_NOSIGNAL);
        const struct can_frame reply = {.can_id = 0x123, .len = 2};
        (void)send(listener, &reply, sizeof reply, MSG_NOSIGNAL);
        (void)hub_step(&hub, 0);
        while (recv(sender, buffer, sizeof buffer, 0) > 0) {
        }
        while ((bytes = recv(listener, buffer, sizeof buffer, 0)) > 0) {
            require_frame(buffer, bytes);
        }
    }
    (void)close(sender);
    (void)hub_step(&hub, 0);
    hub_free(&hub);
    (void)close(listener);
}
