#include "hub_publisher.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/can.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "../../hal/linux/hub_path.h"

#define SEND_TIMEOUT_MS 1000
#define START_TRIES 500
#define START_TRY_NS 10000000
#define PATH_BYTES 4096
#define HUB_PROGRAM "/../host/comanip-hub" /* relative to the folder of this program */

static bool connect_hub(hub_publisher_t *self, const char *bus, char error[], size_t error_size) {
    self->fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    if (self->fd < 0) {
        (void)snprintf(error, error_size, "hub %s: %s", bus, strerror(errno));
        return false;
    }
    self->is_exclusive = hub_connect_by_name(self->fd, bus, HUB_SOURCE_SUFFIX, error, error_size);
    if (!self->is_exclusive && !hub_connect_by_name(self->fd, bus, "", error, error_size)) {
        (void)close(self->fd);
        self->fd = -1;
        return false;
    }
    (void)shutdown(self->fd, SHUT_RD);
    return true;
}

/* Runs in the child process. The hub gets its own process group, so that Ctrl-C does not stop the hub before
 * the simulator. */
static void become_hub(const char *program, const char *bus) {
    const int null_fd = open("/dev/null", O_WRONLY);
    (void)setpgid(0, 0);
    (void)prctl(PR_SET_PDEATHSIG, SIGTERM);
    (void)dup2(null_fd, STDOUT_FILENO);
    (void)execl(program, program, "--bus", bus, "--listen-only", (char *)NULL);
    _exit(127);
}

static bool start_hub(hub_publisher_t *self, const char *bus, char error[], size_t error_size) {
    char program[PATH_BYTES];
    const ssize_t bytes = readlink("/proc/self/exe", program, sizeof program - sizeof HUB_PROGRAM);
    program[bytes > 0 ? bytes : 0] = '\0';
    char *slash = strrchr(program, '/');
    (void)strcpy(slash != NULL ? slash : program, HUB_PROGRAM);
    self->hub = fork();
    if (self->hub == 0) {
        become_hub(program, bus);
    }
    if (self->hub < 0) {
        (void)snprintf(error, error_size, "hub %s: %s cannot be started: %s", bus, program, strerror(errno));
        return false;
    }
    for (int i = 0; i < START_TRIES; i++) {
        if (connect_hub(self, bus, error, error_size)) {
            return true;
        }
        if (waitpid(self->hub, NULL, WNOHANG) == self->hub) {
            self->hub = 0;
            (void)snprintf(error, error_size,
                           "hub %s: %s could not be started or ended at once; `make build` builds it", bus, program);
            return false;
        }
        const struct timespec pause = {.tv_nsec = START_TRY_NS};
        (void)nanosleep(&pause, NULL);
    }
    hub_publisher_close(self);
    return false;
}

bool hub_publisher_open(hub_publisher_t *self, const char *bus, char error[], size_t error_size) {
    *self = (hub_publisher_t){.fd = -1};
    return connect_hub(self, bus, error, error_size) || start_hub(self, bus, error, error_size);
}

static bool send_with_timeout(int fd, const struct canfd_frame *packet, size_t bytes) {
    struct pollfd room = {.fd = fd, .events = POLLOUT};
    while (send(fd, packet, bytes, MSG_DONTWAIT | MSG_NOSIGNAL) < 0) {
        if (errno != EAGAIN || poll(&room, 1, SEND_TIMEOUT_MS) == 0) {
            return false;
        }
    }
    return true;
}

void hub_publisher_send(void *context, const can_frame_t *frame, int64_t end_ns) {
    hub_publisher_t *self = context;
    if (self->fd < 0) {
        self->lost++;
        return;
    }
    struct canfd_frame packet = {.can_id = frame->id, .len = frame->length, .flags = frame->fd ? CANFD_BRS : 0};
    memcpy(packet.data, frame->data, frame->length);
    if (!send_with_timeout(self->fd, &packet, frame->fd ? CANFD_MTU : CAN_MTU)) {
        (void)fprintf(stderr,
                      "comanip-sim: at %.3f s of simulated time, the hub closed the connection or stopped responding; "
                      "the run continues without the hub\n",
                      (double)end_ns * 1e-9);
        (void)close(self->fd);
        self->fd = -1;
        self->lost = 1;
    }
}

void hub_publisher_close(hub_publisher_t *self) {
    if (self->fd >= 0) {
        (void)close(self->fd);
        self->fd = -1;
    }
    if (self->hub > 0) {
        (void)kill(self->hub, SIGTERM);
        (void)kill(self->hub, SIGCONT); /* a hub that SIGSTOP has stopped would not handle SIGTERM */
        (void)waitpid(self->hub, NULL, 0);
        self->hub = 0;
    }
}
