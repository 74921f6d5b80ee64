/* The hub forwards every frame of a client to all other clients, in one order. It has one thread and one epoll loop and
 * never waits for a client: one that reads too slowly is dropped. */
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
    CLIENT_IS_FULL, /* writing would block: try again when the socket has room */
    CLIENT_IS_GONE,
} client_result_t;

/* A kind of client. None of the functions blocks. */
typedef struct {
    const char *name;
    /* Called for a new client. NULL: the client receives frames at once; otherwise the endpoint sets is_listening. */
    client_result_t (*greet)(const client_t *client);
    client_result_t (*read)(hub_t *hub, client_t *client);
    /* Sends frames from client->position up to the journal's end at most, and advances client->position. */
    client_result_t (*write)(hub_t *hub, client_t *client);
    size_t session_bytes; /* size of client->session, which is zero at the start */
} endpoint_t;

struct client {
    const endpoint_t *endpoint; /* NULL: this entry is free */
    void *session;              /* state of the endpoint for this client */
    int fd;
    uint32_t number;   /* identifies the client in messages, and as the sender of a frame */
    uint64_t position; /* in the journal: the next frame to send to the client */
    bool is_listening; /* receives frames */
    bool may_send;
    bool is_full;
    uint64_t refused;  /* packets or commands that were not frames */
    uint64_t silenced; /* frames of a client that may not send */
    uint64_t left_out; /* frames that its protocol cannot carry */
};

struct hub {
    const char *bus; /* name of the bus */
    int settle_ms;   /* time from the answer to a socketcand client to its first frame */
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

/* bus: name of the bus; the string must outlive the hub. False if epoll is not available. */
bool hub_init(hub_t *self, const char *bus);

/* Accepts clients of listen_fd, which is non-blocking and owned by the hub from now on. False if there are
 * HUB_MAX_LISTENERS already. */
bool hub_listen(hub_t *self, int listen_fd, const endpoint_t *endpoint, bool may_send);

/* Adds a client with a connected, non-blocking socket. If there are HUB_MAX_CLIENTS already, prints a message, closes
 * the socket and returns NULL. */
client_t *hub_add_client(hub_t *self, int fd, const endpoint_t *endpoint, bool may_send);

/* Accepts the clients that are waiting. Endpoints call it after reading packets and before hub_receive(), so that every
 * client that connected before a packet was sent receives it. */
void hub_accept(hub_t *self);

/* Called by endpoints for a packet from the client. Forwards it if it is a frame and the client may send; otherwise
 * counts it, with a message for the first. False if it is not a frame. */
bool hub_receive(hub_t *self, client_t *client, const void *packet, size_t bytes);

/* Waits up to timeout_ms for events and handles them. False if there were none and all clients have all frames. */
bool hub_step(hub_t *self, int timeout_ms);

void hub_free(hub_t *self);

#endif
