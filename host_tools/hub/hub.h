/* The hub: every frame of a client goes to all others, in one order. One thread, one epoll loop, no waiting for
 * anybody: a client that cannot follow is dropped. */
#ifndef COMANIP_HUB_H
#define COMANIP_HUB_H

#include <stdbool.h>
#include <stdint.h>

#include "journal.h"

#define HUB_MAX_CLIENTS 64
#define HUB_MAX_LISTENERS 3
#define HUB_SETTLE_MS 300

typedef struct hub hub_t;
typedef struct client client_t;

typedef enum {
    CLIENT_GOES_ON,
    CLIENT_IS_FULL, /* writing would wait: again when the socket has room */
    CLIENT_IS_GONE,
} client_result_t;

/* A kind of client. None of the functions waits. */
typedef struct {
    const char *name;
    client_result_t (*greet)(const client_t *client); /* NULL, or: frames come when the endpoint says so */
    client_result_t (*read)(hub_t *hub, client_t *client);
    /* Sends frames from client->position on, and moves it; not beyond the journal's end. */
    client_result_t (*write)(hub_t *hub, client_t *client);
    size_t session_bytes; /* of client->session, zero at the start */
} endpoint_t;

struct client {
    const endpoint_t *endpoint; /* NULL: a free place */
    void *session;              /* what the endpoint remembers of it */
    int fd;
    uint32_t number;   /* for messages, and to know its own frames */
    uint64_t position; /* in the journal: the next frame to be sent to it */
    bool is_listening; /* wants frames */
    bool may_send;
    bool is_full;
    uint64_t refused;  /* packets or commands that were not frames */
    uint64_t silenced; /* frames of a client that may not send */
    uint64_t left_out; /* frames that its protocol cannot carry */
};

struct hub {
    const char *bus; /* its name */
    int settle_ms;   /* from the answer to a socketcand client to its first frame */
    int epoll_fd;
    uint32_t last_number;
    struct {
        int fd;
        const endpoint_t *endpoint;
        bool may_send;
    } listener[HUB_MAX_LISTENERS];
    int listener_count;
    client_t client[HUB_MAX_CLIENTS];
    journal_t journal;
};

/* `bus` must outlive the hub. */
bool hub_init(hub_t *self, const char *bus);

/* Clients of listen_fd, which is non-blocking and from now on the hub's, are accepted. At most HUB_MAX_LISTENERS. */
bool hub_listen(hub_t *self, int listen_fd, const endpoint_t *endpoint, bool may_send);

/* Takes a connected, non-blocking socket. NULL, and the socket closed with a message, if there is no place. */
client_t *hub_add_client(hub_t *self, int fd, const endpoint_t *endpoint, bool may_send);

/* For endpoints, after taking packets from a socket and before hub_receive(): whoever connected before a packet was
 * sent gets it. */
void hub_accept(hub_t *self);

/* For endpoints: a packet came from the client. It is forwarded, or counted with a message if it is no frame, or if the
 * client may not send. False if it is no frame. */
bool hub_receive(hub_t *self, client_t *client, const void *packet, size_t bytes);

/* Waits up to timeout_ms for something to do, and does it. False if there was nothing, and
 * all have all frames. */
bool hub_step(hub_t *self, int timeout_ms);

void hub_free(hub_t *self);

#endif
