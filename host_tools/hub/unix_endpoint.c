/* Clients of the Unix socket: see unix_endpoint.h. */
#include "unix_endpoint.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "../../hal/linux/hub_path.h"

#define BATCH 64

int unix_endpoint_open(const char *path, char error[], size_t error_size) {
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    memcpy(address.sun_path, path, strnlen(path, HUB_PATH_BYTES - 1));
    const int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    (void)unlink(path); /* left behind by a killed hub: the lock ensures that no other hub is running */
    const mode_t mask = umask(S_IRWXG | S_IRWXO);
    const bool is_open =
        fd >= 0 && bind(fd, (const struct sockaddr *)&address, sizeof address) == 0 && listen(fd, HUB_MAX_CLIENTS) == 0;
    const int cause = errno;
    (void)umask(mask);
    if (!is_open) {
        (void)snprintf(error, error_size, "%s: cannot listen there: %s", path, strerror(cause));
        if (fd >= 0) {
            (void)close(fd);
        }
        return -1;
    }
    return fd;
}

static client_result_t read_frames(hub_t *hub, client_t *client) {
    char packet[BATCH][CANFD_MTU + 1]; /* the spare byte detects packets that are too long */
    struct iovec part[BATCH];
    struct mmsghdr message[BATCH];
    memset(message, 0, sizeof message);
    for (int i = 0; i < BATCH; i++) {
        part[i] = (struct iovec){.iov_base = packet[i], .iov_len = sizeof packet[i]};
        message[i].msg_hdr.msg_iov = &part[i];
        message[i].msg_hdr.msg_iovlen = 1;
    }
    const int received = recvmmsg(client->fd, message, BATCH, MSG_DONTWAIT, NULL);
    if (received <= 0) {
        return received < 0 && (errno == EAGAIN || errno == EINTR) ? CLIENT_GOES_ON : CLIENT_IS_GONE;
    }
    hub_accept(hub);
    for (int i = 0; i < received; i++) {
        if (message[i].msg_len == 0) { /* end of file, or an empty packet, which looks the same */
            return CLIENT_IS_GONE;
        }
        (void)hub_receive(hub, client, packet[i], message[i].msg_len);
    }
    return CLIENT_GOES_ON;
}

static client_result_t write_frames(hub_t *hub, client_t *client) {
    while (client->position != hub->journal.end) {
        struct iovec part[BATCH];
        struct mmsghdr message[BATCH];
        uint64_t after[BATCH]; /* client->position after this message has been sent */
        unsigned count = 0;
        memset(message, 0, sizeof message);
        uint64_t position = client->position;
        while (position != hub->journal.end && count < BATCH) {
            const journal_entry_t *entry = journal_at(&hub->journal, position++);
            if (entry->sender != client->number) {
                part[count] = (struct iovec){.iov_base = (void *)(uintptr_t)&entry->frame, .iov_len = entry->bytes};
                message[count].msg_hdr.msg_iov = &part[count];
                message[count].msg_hdr.msg_iovlen = 1;
                after[count++] = position;
            }
        }
        const int sent = count > 0 ? sendmmsg(client->fd, message, count, MSG_DONTWAIT | MSG_NOSIGNAL) : 0;
        if (sent < 0 && errno == EPIPE) {
            client->is_listening = false; /* the client has shut down receiving; read_frames() detects disconnects */
            return CLIENT_GOES_ON;
        }
        if (sent < 0) {
            return errno == EAGAIN || errno == ENOBUFS || errno == EINTR ? CLIENT_IS_FULL : CLIENT_IS_GONE;
        }
        client->position = (unsigned)sent == count ? position : sent > 0 ? after[sent - 1] : client->position;
    }
    return CLIENT_GOES_ON;
}

const endpoint_t unix_endpoint = {
    .name = "unix", .greet = NULL, .read = read_frames, .write = write_frames, .session_bytes = 0};
