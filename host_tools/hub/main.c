/* comanip-hub: a CAN bus for the processes on this machine, without CAN in the kernel. */
#include <errno.h>
#include <fcntl.h>
#include <getopt.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "../../hal/linux/hub_path.h"
#include "hub.h"
#include "socketcand_endpoint.h"
#include "unix_endpoint.h"

#define EXIT_WRONG_USE 2
#define ERROR_BYTES 512
#define STEP_MS 100
#define FLUSH_STEPS 2000 /* largest number of steps of 1 ms at the end, for clients to read the last frames */

static const char usage[] =
    "comanip-hub: a CAN bus for the processes on this machine, without CAN in the kernel\n"
    "\n"
    "usage: build/host/comanip-hub [--bus NAME] [--socketcand PORT|off] [--listen-only]\n"
    "       make hub CAN=NAME\n"
    "\n"
    "  --bus NAME             name of the bus (default vcan0)\n"
    "  --socketcand PORT|off  port for python-can and SavvyCAN, at 127.0.0.1 only; 0: any free port\n"
    "                         (default 29536, or off if that port is in use)\n"
    "  --listen-only          only clients of the socket NAME.source may send; all others only listen\n"
    "  -h, --help             print this text\n"
    "\n"
    "The socket is $COMANIP_HUB_DIR/NAME, by default /tmp/comanip-hub-UID/NAME. Run can-utils and python-can with\n"
    "build/host/with-can, for example: build/host/with-can candump -ta vcan0\n"
    "\n"
    "exit status: 0 ended by a signal, 1 cannot run, 2 usage error\n";

typedef struct {
    const char *bus;
    int port; /* -1: off */
    bool is_port_given;
    bool is_listen_only;
} options_t;

static volatile sig_atomic_t stopped;

static void on_stop(int signal_number) {
    (void)signal_number;
    stopped = 1;
}

static int complain(const char *error, int status) {
    (void)fprintf(stderr, "comanip-hub: %s\n", error);
    return status;
}

static bool parse_port(const char *text, int *port) {
    if (strcmp(text, "off") == 0) {
        *port = -1;
        return true;
    }
    const size_t digits = strlen(text);
    if (digits == 0 || digits > 5 || strspn(text, "0123456789") != digits) {
        return false;
    }
    *port = atoi(text);
    return *port <= 65535;
}

/* Parses the arguments. Returns an exit status if the program should end at once, else -1. */
static int parse_options(options_t *self, int argc, char *argv[]) {
    static const struct option table[] = {{"bus", required_argument, NULL, 'b'},
                                          {"socketcand", required_argument, NULL, 's'},
                                          {"listen-only", no_argument, NULL, 'l'},
                                          {"help", no_argument, NULL, 'h'},
                                          {NULL, 0, NULL, 0}};
    char error[ERROR_BYTES];
    int option;
    *self = (options_t){.bus = "vcan0", .port = SOCKETCAND_DEFAULT_PORT};
    opterr = 0;
    while ((option = getopt_long(argc, argv, ":h", table, NULL)) != -1) {
        switch (option) {
        case 'b': self->bus = optarg; break;
        case 's':
            self->is_port_given = true;
            if (!parse_port(optarg, &self->port)) {
                (void)snprintf(error, sizeof error, "--socketcand '%.200s': expected a port from 0 to 65535, or off",
                               optarg);
                return complain(error, EXIT_WRONG_USE);
            }
            break;
        case 'l': self->is_listen_only = true; break;
        case 'h': (void)fputs(usage, stdout); return EXIT_SUCCESS;
        default:
            (void)snprintf(error, sizeof error, "'%.200s': %s; --help lists the options", argv[optind - 1],
                           option == ':' ? "expected a value after it" : "no such option");
            return complain(error, EXIT_WRONG_USE);
        }
    }
    if (optind < argc) {
        (void)snprintf(error, sizeof error, "'%.200s': expected options only; --help lists them", argv[optind]);
        return complain(error, EXIT_WRONG_USE);
    }
    return -1;
}

/* Ensures that a bus has only one hub. The process holds the lock until it ends. */
static bool lock(const char *path, const char *bus, char error[ERROR_BYTES]) {
    const int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, S_IRUSR | S_IWUSR);
    if (fd < 0) {
        (void)snprintf(error, ERROR_BYTES, "%s: %s", path, strerror(errno));
        return false;
    }
    if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
        (void)snprintf(error, ERROR_BYTES, "bus %s: another hub already runs this bus", bus);
        return false;
    }
    return true;
}

static bool listen_unix(hub_t *hub, const char *path, bool may_send, char error[ERROR_BYTES]) {
    const int fd = unix_endpoint_open(path, error, ERROR_BYTES);
    return fd >= 0 && hub_listen(hub, fd, &unix_endpoint, may_send);
}

static bool listen_socketcand(hub_t *hub, const options_t *options, char error[ERROR_BYTES]) {
    if (options->port < 0) {
        return true;
    }
    const int fd = socketcand_endpoint_open(options->port);
    if (fd < 0) {
        (void)snprintf(error, ERROR_BYTES,
                       "socketcand: port %d of 127.0.0.1: %s; choose another with --socketcand PORT, or off",
                       options->port, strerror(errno));
        if (options->is_port_given || errno != EADDRINUSE) {
            return false;
        }
        (void)complain(error, 0);
        return true;
    }
    (void)printf("comanip-hub: socketcand at 127.0.0.1:%d\n", socketcand_endpoint_port(fd));
    return hub_listen(hub, fd, &socketcand_endpoint, !options->is_listen_only);
}

static void run(hub_t *hub) {
    while (stopped == 0) {
        (void)hub_step(hub, STEP_MS);
    }
    for (int step = 0; step < FLUSH_STEPS && hub_step(hub, 1); step++) {
    }
}

int main(int argc, char *argv[]) {
    static hub_t hub;
    options_t options;
    char error[ERROR_BYTES] = "cannot start: epoll is not available, or memory or epoll watches are exhausted";
    char folder[HUB_PATH_BYTES], path[HUB_PATH_BYTES], source[HUB_PATH_BYTES], lock_path[HUB_PATH_BYTES];
    const int status = parse_options(&options, argc, argv);
    if (status >= 0) {
        return status;
    }
    if (!hub_folder(folder, error, sizeof error) || !hub_path(path, folder, options.bus, "", error, sizeof error) ||
        !hub_path(source, folder, options.bus, HUB_SOURCE_SUFFIX, error, sizeof error) ||
        !hub_path(lock_path, folder, options.bus, HUB_LOCK_SUFFIX, error, sizeof error)) {
        return complain(error, EXIT_WRONG_USE);
    }
    (void)mkdir(folder, S_IRWXU);
    const struct sigaction stop = {.sa_handler = on_stop}, ignore = {.sa_handler = SIG_IGN};
    (void)sigaction(SIGINT, &stop, NULL);
    (void)sigaction(SIGTERM, &stop, NULL);
    (void)sigaction(SIGPIPE, &ignore, NULL);
    if (!hub_folder_is_trusted(folder, error, sizeof error) || !lock(lock_path, options.bus, error) ||
        !hub_init(&hub, options.bus) || !listen_socketcand(&hub, &options, error) ||
        (options.is_listen_only && !listen_unix(&hub, source, true, error)) ||
        !listen_unix(&hub, path, !options.is_listen_only, error)) {
        return complain(error, EXIT_FAILURE);
    }
    (void)printf("comanip-hub: bus %s at %s%s\n", options.bus, path,
                 options.is_listen_only ? ", listen-only: senders connect to NAME.source" : "");
    (void)fflush(stdout);
    run(&hub);
    (void)unlink(path);
    if (options.is_listen_only) {
        (void)unlink(source);
    }
    hub_free(&hub);
    return EXIT_SUCCESS;
}
