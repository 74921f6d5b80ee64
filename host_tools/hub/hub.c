/* The hub's clients, listeners and event loop: see hub.h. */
#include "hub.h"

#include <errno.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#define EVENTS 64

bool hub_init(hub_t *self, const char *bus) {
    memset(self, 0, offsetof(hub_t, journal));
    self->journal.end = 0;
    self->bus = bus;
    self->settle_ms = HUB_SETTLE_MS;
    self->epoll_fd = epoll_create1(EPOLL_CLOEXEC);
    return self->epoll_fd >= 0;
}

/* Calls epoll_ctl(). index: identifies fd in later events. It is the index of a client, or HUB_MAX_CLIENTS plus the
 * index of a listener. */
static bool watch(const hub_t *self, int operation, int fd, uint32_t index, uint32_t events) {
    struct epoll_event event = {.events = events, .data.u32 = index};
    return epoll_ctl(self->epoll_fd, operation, fd, &event) == 0;
}

static void watch_client(hub_t *self, client_t *client, bool is_full) {
    client->is_full = is_full;
    const uint32_t events = EPOLLIN | (is_full ? (uint32_t)EPOLLOUT : 0u);
    (void)watch(self, EPOLL_CTL_MOD, client->fd, (uint32_t)(client - self->client), events);
}

bool hub_listen(hub_t *self, int listen_fd, const endpoint_t *endpoint, bool may_send) {
    const int i = self->listener_count;
    if (i == HUB_MAX_LISTENERS || !watch(self, EPOLL_CTL_ADD, listen_fd, HUB_MAX_CLIENTS + (uint32_t)i, EPOLLIN)) {
        return false;
    }
    self->listener[i].fd = listen_fd;
    self->listener[i].endpoint = endpoint;
    self->listener[i].may_send = may_send;
    self->listener_count++;
    return true;
}

static void count(const client_t *client, uint64_t frames, const char *what) {
    if (frames > 0) {
        (void)fprintf(stderr, "comanip-hub: %s client %u: %llu %s\n", client->endpoint->name, client->number,
                      (unsigned long long)frames, what);
    }
}

static void remove_client(client_t *client) {
    count(client, client->refused, "packets or commands were refused in total");
    count(client, client->silenced, "frames were not forwarded, because this client may only listen");
    count(client, client->left_out, "frames were left out, because the client's protocol cannot carry them");
    (void)close(client->fd); /* also removes it from epoll */
    free(client->session);
    client->endpoint = NULL;
}

client_t *hub_add_client(hub_t *self, int fd, const endpoint_t *endpoint, bool may_send) {
    uint32_t index = 0;
    while (index < HUB_MAX_CLIENTS && self->client[index].endpoint != NULL) {
        index++;
    }
    void *session = index < HUB_MAX_CLIENTS ? calloc(1, endpoint->session_bytes + 1) : NULL;
    if (session == NULL || !watch(self, EPOLL_CTL_ADD, fd, index, EPOLLIN)) {
        (void)fprintf(stderr,
                      "comanip-hub: %s client rejected: either %d clients, the maximum, are connected, or memory or "
                      "epoll watches are exhausted; disconnect other clients and try again\n",
                      endpoint->name, HUB_MAX_CLIENTS);
        free(session);
        (void)close(fd);
        return NULL;
    }
    client_t *client = &self->client[index];
    *client = (client_t){.endpoint = endpoint,
                         .session = session,
                         .fd = fd,
                         .number = ++self->last_number,
                         .position = self->journal.end,
                         .is_listening = endpoint->greet == NULL,
                         .may_send = may_send};
    if (endpoint->greet != NULL && endpoint->greet(client) == CLIENT_IS_GONE) {
        remove_client(client);
        return NULL;
    }
    return client;
}

void hub_accept(hub_t *self) {
    for (int i = 0; i < self->listener_count; i++) {
        int fd;
        while ((fd = accept4(self->listener[i].fd, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC)) >= 0) {
            (void)hub_add_client(self, fd, self->listener[i].endpoint, self->listener[i].may_send);
        }
        if (errno != EAGAIN && errno != ECONNABORTED && errno != EINTR) {
            (void)fprintf(stderr, "comanip-hub: a client could not be accepted: %s\n", strerror(errno));
        }
    }
}

bool hub_receive(hub_t *self, client_t *client, const void *packet, size_t bytes) {
    if (!journal_accepts(packet, bytes)) {
        if (client->refused++ == 0) {
            (void)fprintf(stderr,
                          "comanip-hub: %s client %u: a packet of %zu bytes is refused: expected a can_frame (%zu "
                          "bytes, length up to 8) or canfd_frame (%zu, up to 64), and 11 bits of id unless extended\n",
                          client->endpoint->name, client->number, bytes, (size_t)CAN_MTU, (size_t)CANFD_MTU);
        }
        return false;
    }
    if (!client->may_send) {
        if (client->silenced++ == 0) {
            (void)fprintf(stderr,
                          "comanip-hub: %s client %u sends, but may only listen: its frames are not forwarded\n",
                          client->endpoint->name, client->number);
        }
        return true;
    }
    struct timespec now;
    (void)clock_gettime(CLOCK_REALTIME, &now);
    journal_append(&self->journal, packet, bytes, client->number, &now);
    return true;
}

static void handle(hub_t *self, const struct epoll_event *event) {
    const uint32_t index = event->data.u32;
    if (index >= HUB_MAX_CLIENTS) {
        hub_accept(self);
        return;
    }
    client_t *client = &self->client[index];
    if (client->endpoint == NULL) {
        return;
    }
    if ((event->events & EPOLLOUT) != 0) {
        watch_client(self, client, false);
    }
    const uint32_t readable = EPOLLIN | EPOLLHUP | EPOLLERR;
    if ((event->events & readable) != 0 && client->endpoint->read(self, client) == CLIENT_IS_GONE) {
        remove_client(client);
    }
}

/* Sends waiting frames to the client. Returns true if frames were sent or are still waiting. */
static bool serve(hub_t *self, client_t *client) {
    if (!client->is_listening) {
        client->position = self->journal.end;
    }
    if (client->position == self->journal.end) {
        return false;
    }
    if (!journal_has(&self->journal, client->position)) {
        (void)fprintf(stderr,
                      "comanip-hub: %s client %u is dropped: it reads too slowly, more than %u frames are waiting\n",
                      client->endpoint->name, client->number, JOURNAL_FRAMES);
        remove_client(client);
        return false;
    }
    if (client->is_full) {
        return true;
    }
    const client_result_t result = client->endpoint->write(self, client);
    if (result == CLIENT_IS_GONE) {
        remove_client(client);
        return false;
    }
    if (result == CLIENT_IS_FULL) {
        watch_client(self, client, true);
    }
    return true;
}

bool hub_step(hub_t *self, int timeout_ms) {
    struct epoll_event events[EVENTS];
    const int count_of_events = epoll_wait(self->epoll_fd, events, EVENTS, timeout_ms);
    bool is_busy = count_of_events > 0;
    for (int i = 0; i < count_of_events; i++) {
        handle(self, &events[i]);
    }
    for (int i = 0; i < HUB_MAX_CLIENTS; i++) {
        if (self->client[i].endpoint != NULL) {
            is_busy = serve(self, &self->client[i]) || is_busy;
        }
    }
    return is_busy;
}

void hub_free(hub_t *self) {
    for (int i = 0; i < HUB_MAX_CLIENTS; i++) {
        if (self->client[i].endpoint != NULL) {
            remove_client(&self->client[i]);
        }
    }
    for (int i = 0; i < self->listener_count; i++) {
        (void)close(self->listener[i].fd);
    }
    (void)close(self->epoll_fd);
}
