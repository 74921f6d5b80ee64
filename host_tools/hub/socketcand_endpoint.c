/* TCP clients that speak socketcand: see socketcand_endpoint.h. */
#include "socketcand_endpoint.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "socketcand.h"

#define OUT_BYTES 16384

typedef struct {
    char in[SOCKETCAND_COMMAND_BYTES];
    size_t in_bytes;
    char out[OUT_BYTES];
    size_t out_bytes, out_sent;
    bool is_open;         /* the client has opened the bus */
    int64_t raw_since_ms; /* start of rawmode, 0 before it */
} session_t;

static int64_t now_ms(void) {
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

static client_result_t flush(const client_t *client) {
    session_t *session = client->session;
    while (session->out_sent < session->out_bytes) {
        const ssize_t sent = send(client->fd, session->out + session->out_sent, session->out_bytes - session->out_sent,
                                  MSG_DONTWAIT | MSG_NOSIGNAL);
        if (sent < 0) {
            return errno == EAGAIN || errno == EINTR ? CLIENT_IS_FULL : CLIENT_IS_GONE;
        }
        session->out_sent += (size_t)sent;
    }
    session->out_bytes = session->out_sent = 0;
    return CLIENT_GOES_ON;
}

/* Sends an answer. A client that does not read its answers is dropped. */
static client_result_t answer(const client_t *client, const char *text) {
    session_t *session = client->session;
    const size_t length = strlen(text);
    if (session->out_bytes + length > sizeof session->out) {
        return CLIENT_IS_GONE;
    }
    memcpy(session->out + session->out_bytes, text, length);
    session->out_bytes += length;
    return flush(client) == CLIENT_IS_GONE ? CLIENT_IS_GONE : CLIENT_GOES_ON;
}

static client_result_t refuse(client_t *client, const char *text) {
    if (client->refused++ == 0) {
        (void)fprintf(stderr, "comanip-hub: socketcand client %u: a command is refused: %s\n", client->number, text);
    }
    return answer(client, text);
}

static client_result_t execute(hub_t *hub, client_t *client, const char *text, size_t length) {
    session_t *session = client->session;
    const socketcand_command_t command = socketcand_parse(text, length);
    switch (command.kind) {
    case SOCKETCAND_OPEN:
        if (strcmp(command.bus, hub->bus) != 0) {
            return refuse(client, "< error could not open bus >");
        }
        session->is_open = true;
        return answer(client, "< ok >");
    case SOCKETCAND_RAWMODE:
        if (!session->is_open) {
            return refuse(client, "< error no bus is open >");
        }
        if (!client->is_listening) {
            session->raw_since_ms = now_ms();
            client->position = hub->journal.end;
            client->is_listening = true;
        }
        return answer(client, "< ok >");
    case SOCKETCAND_ECHO: return answer(client, "< echo >");
    case SOCKETCAND_SEND:
        if (!client->is_listening) {
            return refuse(client, "< error not in rawmode >");
        }
        (void)hub_receive(hub, client, &command.frame, command.bytes);
        return CLIENT_GOES_ON;
    case SOCKETCAND_MALFORMED: break;
    }
    return refuse(client, "< error unknown or malformed command >");
}

/* Executes the complete commands in session->in and keeps the rest. */
static client_result_t execute_all(hub_t *hub, client_t *client) {
    session_t *session = client->session;
    size_t done = 0;
    client_result_t result = CLIENT_GOES_ON;
    while (result == CLIENT_GOES_ON) {
        const char *begin = session->in + done;
        const size_t rest = session->in_bytes - done;
        const char *end = memchr(begin, '>', rest);
        if (end == NULL) {
            break;
        }
        const char *open = memchr(begin, '<', (size_t)(end - begin));
        done += (size_t)(end - begin) + 1;
        result = open != NULL ? execute(hub, client, open + 1, (size_t)(end - open) - 1)
                              : refuse(client, "< error a command without its beginning >");
    }
    session->in_bytes -= done;
    memmove(session->in, session->in + done, session->in_bytes);
    if (result == CLIENT_GOES_ON && session->in_bytes == sizeof session->in) {
        (void)refuse(client, "< error command too long >");
        return CLIENT_IS_GONE;
    }
    return result;
}

static client_result_t greet(const client_t *client) {
    return answer(client, "< hi >");
}

static client_result_t read_commands(hub_t *hub, client_t *client) {
    session_t *session = client->session;
    const ssize_t bytes =
        recv(client->fd, session->in + session->in_bytes, sizeof session->in - session->in_bytes, MSG_DONTWAIT);
    if (bytes <= 0) {
        return bytes < 0 && (errno == EAGAIN || errno == EINTR) ? CLIENT_GOES_ON : CLIENT_IS_GONE;
    }
    session->in_bytes += (size_t)bytes;
    hub_accept(hub);
    return execute_all(hub, client);
}

/* Appends the frame's line to the output. Returns its length, or 0 if the protocol cannot carry the frame. */
static size_t put_line(session_t *session, const journal_entry_t *entry) {
    char line[SOCKETCAND_LINE_BYTES];
    const size_t bytes = socketcand_format(entry, line);
    if (bytes > 0) {
        char *out = session->out + session->out_bytes;
        const size_t blanks = SOCKETCAND_PADDED_BYTES - bytes;
        memset(out, ' ', blanks);
        memcpy(out + blanks, line, bytes);
        session->out_bytes += SOCKETCAND_PADDED_BYTES;
    }
    return bytes;
}

static client_result_t write_frames(hub_t *hub, client_t *client) {
    session_t *session = client->session;
    /* The client must have read `< ok >` before the first frame arrives, because python-can treats everything that one
     * recv() returns as the answer. Frames that arrive in the meantime are sent afterwards. */
    if (now_ms() < session->raw_since_ms + hub->settle_ms) {
        return CLIENT_GOES_ON;
    }
    client_result_t result = flush(client);
    while (result == CLIENT_GOES_ON && client->position != hub->journal.end) {
        while (client->position != hub->journal.end &&
               session->out_bytes + SOCKETCAND_PADDED_BYTES <= sizeof session->out) {
            const journal_entry_t *entry = journal_at(&hub->journal, client->position++);
            if (entry->sender == client->number) {
                continue;
            }
            const size_t bytes = put_line(session, entry);
            if (bytes == 0 && client->left_out++ == 0) {
                (void)fprintf(stderr,
                              "comanip-hub: socketcand client %u: a remote frame is left out, because the protocol "
                              "cannot carry it\n",
                              client->number);
            }
        }
        result = flush(client);
    }
    return result;
}

int socketcand_endpoint_open(int port) {
    const struct sockaddr_in address = {
        .sin_family = AF_INET, .sin_port = htons((uint16_t)port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    const int on = 1;
    if (fd < 0 || setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0 ||
        setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on) != 0 || /* inherited by the connections */
        bind(fd, (const struct sockaddr *)&address, sizeof address) != 0 || listen(fd, HUB_MAX_CLIENTS) != 0) {
        const int cause = errno;
        if (fd >= 0) {
            (void)close(fd);
        }
        errno = cause;
        return -1;
    }
    return fd;
}

int socketcand_endpoint_port(int listen_fd) {
    struct sockaddr_in address;
    socklen_t length = sizeof address;
    return getsockname(listen_fd, (struct sockaddr *)&address, &length) == 0 ? ntohs(address.sin_port) : -1;
}

const endpoint_t socketcand_endpoint = {.name = "socketcand",
                                        .greet = greet,
                                        .read = read_commands,
                                        .write = write_frames,
                                        .session_bytes = sizeof(session_t)};
