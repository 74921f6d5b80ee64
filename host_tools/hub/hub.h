/* The hub forwards every frame of a client to all other clients. All clients receive the frames in the same order. The
 * hub has one thread with an epoll loop and never waits for a client. Clients that read too slowly are dropped. */
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
    CLIENT_IS_FULL, /* the socket has no room: the hub tries again when there is room */
    CLIENT_IS_GONE,
} client_result_t;

/* A kind of client. None of the functions blocks. */
typedef struct {
    const char *name;
    /* Called for a new client. The hub sends no frames to this client until the endpoint sets is_listening. If greet is
     * NULL, the hub sends frames from the start. */
    client_result_t (*greet)(const client_t *client);
    client_result_t (*read)(hub_t *hub, client_t *client);
    /* Sends the frames from client->position on, up to the journal's end at most, and advances client->position. */
    client_result_t (*write)(hub_t *hub, client_t *client);
    size_t session_bytes; /* size of client->session, which is initialised to zero */
} endpoint_t;

struct client {
    const endpoint_t *endpoint; /* NULL: this entry is free */
    void *session;              /* state of the endpoint for this client */
    int fd;
    uint32_t number;   /* identifies the client in messages, and as the sender of a frame */
    uint64_t position; /* journal position of the next frame to send to the client */
    bool is_listening; /* frames are sent to the client */
    bool may_send;
    bool is_full;
    uint64_t refused;  /* number of malformed packets or commands */
    uint64_t silenced; /* number of frames not forwarded, because may_send is false */
    uint64_t left_out; /* number of frames that the client's protocol cannot carry */
};

struct hub {
    const char *bus; /* name of the bus */
    int settle_ms;   /* minimum time between the answer to rawmode and the first frame to a socketcand client */
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

/* Initialises the hub. bus: name of the bus; the string must outlive the hub. Returns false if epoll is not available.
 */
bool hub_init(hub_t *self, const char *bus);

/* Adds a listening, non-blocking socket, from which the hub accepts clients. The hub closes the socket at the end.
 * Returns false if there are already HUB_MAX_LISTENERS, or if epoll refuses the socket. */
bool hub_listen(hub_t *self, int listen_fd, const endpoint_t *endpoint, bool may_send);

/* Adds a client with a connected, non-blocking socket. If there are already HUB_MAX_CLIENTS or memory is exhausted,
 * prints a message, closes the socket and returns NULL. Also returns NULL if the client has already disconnected. */
client_t *hub_add_client(hub_t *self, int fd, const endpoint_t *endpoint, bool may_send);

/* Accepts the clients that are waiting. Endpoints call this after reading packets and before hub_receive(), so that a
 * packet reaches every client that connected before the packet was sent. */
void hub_accept(hub_t *self);

/* Handles a packet from the client; called by endpoints. Forwards the packet if it is a frame and the client may send.
 * Otherwise counts the packet and, the first time, prints a message. Returns false if the packet is not a frame. */
bool hub_receive(hub_t *self, client_t *client, const void *packet, size_t bytes);

/* Waits up to timeout_ms for events and handles them. Returns false if there were no events and no frames are waiting.
 */
bool hub_step(hub_t *self, int timeout_ms);

void hub_free(hub_t *self);

#endif
