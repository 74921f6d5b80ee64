/* libcomanip-can.so, a library for LD_PRELOAD that provides raw CAN sockets on machines whose kernel has none. Calls on
 * a CAN socket are redirected to the hub. All other calls are passed to libc unchanged. There is no support for
 * CAN_BCM, ISO-TP, J1939, MSG_CONFIRM on own frames, or sockets that are duplicated or inherited by another
 * program. */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <net/if.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include "can_socket.h"
#include "interface_names.h"

#pragma GCC visibility push(default) /* all other symbols of the library are hidden */

/* Defines next_NAME, the libc function that the function NAME in this file replaces. */
#define NEXT(name)                                                                                                     \
    static __typeof__(name) *next_##name;                                                                              \
    if (next_##name == NULL) {                                                                                         \
        void *symbol = dlsym(RTLD_NEXT, #name);                                                                        \
        memcpy(&next_##name, &symbol, sizeof next_##name);                                                             \
    }

/* ---- interfaces */

unsigned if_nametoindex(const char *name) {
    NEXT(if_nametoindex)
    const unsigned index = next_if_nametoindex(name);
    return index != 0 ? index : interface_index(name);
}

char *if_indextoname(unsigned index, char name[IF_NAMESIZE]) {
    NEXT(if_indextoname)
    const char *ours = interface_name(index);
    return ours != NULL ? strcpy(name, ours) : next_if_indextoname(index, name);
}

/* Answers an ioctl() request about the interface of a hub. Returns false for other requests and other interfaces: the
 * kernel answers these. */
static bool answer(unsigned long request, struct ifreq *interface) {
    if (request == SIOCGIFNAME) {
        const char *name = interface_name((unsigned)interface->ifr_ifindex);
        return name != NULL && strcpy(interface->ifr_name, name) != NULL;
    }
    if (request != SIOCGIFINDEX && request != SIOCGIFMTU && request != SIOCGIFFLAGS) {
        return false;
    }
    char name[IFNAMSIZ] = "";
    memcpy(name, interface->ifr_name, sizeof name - 1);
    const unsigned index = interface_index(name);
    if (request == SIOCGIFINDEX) {
        interface->ifr_ifindex = index != 0 ? (int)index : interface->ifr_ifindex;
    } else if (request == SIOCGIFMTU) {
        interface->ifr_mtu = index != 0 ? (int)CANFD_MTU : interface->ifr_mtu;
    } else if (index != 0) {
        interface->ifr_flags = IFF_UP | IFF_RUNNING | IFF_NOARP;
    }
    return index != 0;
}

int ioctl(int fd, unsigned long request, ...) {
    NEXT(ioctl)
    va_list arguments;
    va_start(arguments, request);
    void *argument = va_arg(arguments, void *);
    va_end(arguments);
    return can_socket_find(fd) != NULL && answer(request, argument) ? 0 : next_ioctl(fd, request, argument);
}

/* ---- opening, binding, options, closing. glibc declares addresses as __SOCKADDR_ARG, a union of pointers */

int socket(int domain, int type, int protocol) {
    NEXT(socket)
    const int fd = next_socket(domain, type, protocol);
    const int flags = SOCK_NONBLOCK | SOCK_CLOEXEC;
    if (fd >= 0 || domain != PF_CAN || (type & ~flags) != SOCK_RAW || protocol != CAN_RAW) {
        return fd;
    }
    return can_socket_adopt(next_socket(AF_UNIX, SOCK_SEQPACKET | (type & flags), 0));
}

int close(int fd) {
    NEXT(close)
    can_socket_t *can = can_socket_find(fd);
    if (can != NULL) {
        can_socket_forget(can);
    }
    return next_close(fd);
}

static unsigned index_of(const struct sockaddr *address, socklen_t length) {
    struct sockaddr_can can;
    const size_t needed = offsetof(struct sockaddr_can, can_ifindex) + sizeof can.can_ifindex;
    if (address == NULL || length < needed || address->sa_family != AF_CAN) {
        return 0;
    }
    memcpy(&can, address, needed);
    return (unsigned)can.can_ifindex;
}

static void write_address(unsigned index, void *address, socklen_t *length) {
    const struct sockaddr_can can = {.can_family = AF_CAN, .can_ifindex = (int)index};
    memcpy(address, &can, *length < sizeof can ? *length : sizeof can);
    *length = sizeof can;
}

int bind(int fd, __CONST_SOCKADDR_ARG address, socklen_t length) {
    NEXT(bind)
    can_socket_t *can = can_socket_find(fd);
    if (can == NULL) {
        return next_bind(fd, address, length);
    }
    if (address.__sockaddr__->sa_family != AF_CAN) {
        errno = EINVAL;
        return -1;
    }
    return can_socket_bind(can, index_of(address.__sockaddr__, length));
}

int getsockname(int fd, __SOCKADDR_ARG address, socklen_t *restrict length) {
    NEXT(getsockname)
    const can_socket_t *can = can_socket_find(fd);
    if (can == NULL) {
        return next_getsockname(fd, address, length);
    }
    write_address(can->index, address.__sockaddr__, length);
    return 0;
}

int setsockopt(int fd, int level, int name, const void *value, socklen_t length) {
    NEXT(setsockopt)
    can_socket_t *can = level == SOL_CAN_RAW ? can_socket_find(fd) : NULL;
    return can != NULL ? can_socket_set_option(can, name, value, length)
                       : next_setsockopt(fd, level, name, value, length);
}

int getsockopt(int fd, int level, int name, void *value, socklen_t *length) {
    NEXT(getsockopt)
    const can_socket_t *can = can_socket_find(fd);
    if (can != NULL && level == SOL_CAN_RAW) {
        return can_socket_get_option(can, name, value, length);
    }
    const int result = next_getsockopt(fd, level, name, value, length);
    if (can != NULL && result == 0 && level == SOL_SOCKET && *length == sizeof(int)) {
        const int emulated = name == SO_DOMAIN     ? AF_CAN
                             : name == SO_TYPE     ? SOCK_RAW
                             : name == SO_PROTOCOL ? CAN_RAW
                                                   : -1;
        if (emulated >= 0) {
            memcpy(value, &emulated, sizeof emulated);
        }
    }
    return result;
}

/* ---- receiving. If the hub has ended or dropped this client, the error is the same as for a removed interface */

static ssize_t received(ssize_t bytes) {
    if (bytes == 0 || (bytes < 0 && errno == ECONNRESET)) {
        errno = ENODEV;
        return -1;
    }
    return bytes;
}

ssize_t read(int fd, void *buffer, size_t size) {
    NEXT(read)
    return can_socket_find(fd) != NULL && size > 0 ? received(next_read(fd, buffer, size))
                                                   : next_read(fd, buffer, size);
}

ssize_t recvmsg(int fd, struct msghdr *message, int flags) {
    NEXT(recvmsg)
    const can_socket_t *can = can_socket_find(fd);
    if (can == NULL) {
        return next_recvmsg(fd, message, flags);
    }
    void *address = message->msg_name;
    socklen_t length = message->msg_namelen;
    message->msg_name = NULL;
    message->msg_namelen = 0;
    const ssize_t bytes = received(next_recvmsg(fd, message, flags));
    message->msg_name = address;
    if (address != NULL && bytes >= 0) {
        write_address(can->index, address, &length);
    }
    message->msg_namelen = length;
    return bytes;
}

ssize_t recvfrom(int fd, void *restrict buffer, size_t size, int flags, __SOCKADDR_ARG address,
                 socklen_t *restrict length) {
    NEXT(recvfrom)
    if (can_socket_find(fd) == NULL) {
        return next_recvfrom(fd, buffer, size, flags, address, length);
    }
    struct iovec part = {.iov_base = buffer, .iov_len = size};
    struct msghdr message = {.msg_name = address.__sockaddr__,
                             .msg_namelen = length != NULL ? *length : 0,
                             .msg_iov = &part,
                             .msg_iovlen = 1};
    const ssize_t bytes = recvmsg(fd, &message, flags);
    if (length != NULL && bytes >= 0) {
        *length = message.msg_namelen;
    }
    return bytes;
}

ssize_t recv(int fd, void *buffer, size_t size, int flags) {
    NEXT(recv)
    return can_socket_find(fd) != NULL ? recvfrom(fd, buffer, size, flags, (__SOCKADDR_ARG){NULL}, NULL)
                                       : next_recv(fd, buffer, size, flags);
}

/* Blocks only for the first message, as with MSG_WAITFORONE. */
int recvmmsg(int fd, struct mmsghdr *message, unsigned count, int flags, struct timespec *timeout) {
    NEXT(recvmmsg)
    if (can_socket_find(fd) == NULL) {
        return next_recvmmsg(fd, message, count, flags, timeout);
    }
    unsigned done = 0;
    while (done < count) {
        const ssize_t bytes =
            recvmsg(fd, &message[done].msg_hdr, (flags & ~MSG_WAITFORONE) | (done > 0 ? MSG_DONTWAIT : 0));
        if (bytes < 0) {
            break;
        }
        message[done++].msg_len = (unsigned)bytes;
    }
    return done > 0 || count == 0 ? (int)done : -1;
}

/* ---- sending */

static size_t size_of(const struct msghdr *message) {
    size_t bytes = 0;
    for (size_t i = 0; i < message->msg_iovlen; i++) {
        bytes += message->msg_iov[i].iov_len;
    }
    return bytes;
}

ssize_t sendmsg(int fd, const struct msghdr *message, int flags) {
    NEXT(sendmsg)
    can_socket_t *can = can_socket_find(fd);
    if (can == NULL) {
        return next_sendmsg(fd, message, flags);
    }
    const size_t bytes = size_of(message);
    if (bytes != CAN_MTU && (bytes != CANFD_MTU || !can->filter.fd_frames)) {
        errno = EINVAL;
        return -1;
    }
    const int route = can_socket_route(can, index_of(message->msg_name, message->msg_namelen));
    if (route < 0 || !can->loopback) { /* without loopback no socket on this machine receives the frame */
        return route < 0 ? -1 : (ssize_t)bytes;
    }
    struct msghdr plain = *message;
    plain.msg_name = NULL;
    plain.msg_namelen = 0;
    const bool waits = (fcntl(fd, F_GETFL) & O_NONBLOCK) == 0;
    const ssize_t sent = next_sendmsg(route, &plain, flags | MSG_NOSIGNAL | (waits ? 0 : MSG_DONTWAIT));
    if (sent < 0 && (errno == EPIPE || errno == ECONNRESET || errno == ENOTCONN)) {
        errno = ENODEV;
    }
    return sent;
}

ssize_t sendto(int fd, const void *buffer, size_t size, int flags, __CONST_SOCKADDR_ARG address, socklen_t length) {
    NEXT(sendto)
    if (can_socket_find(fd) == NULL) {
        return next_sendto(fd, buffer, size, flags, address, length);
    }
    struct iovec part = {.iov_base = (void *)(uintptr_t)buffer, .iov_len = size};
    const struct msghdr message = {
        .msg_name = (void *)(uintptr_t)address.__sockaddr__, .msg_namelen = length, .msg_iov = &part, .msg_iovlen = 1};
    return sendmsg(fd, &message, flags);
}

ssize_t send(int fd, const void *buffer, size_t size, int flags) {
    NEXT(send)
    return can_socket_find(fd) != NULL ? sendto(fd, buffer, size, flags, (__CONST_SOCKADDR_ARG){NULL}, 0)
                                       : next_send(fd, buffer, size, flags);
}

ssize_t write(int fd, const void *buffer, size_t size) {
    NEXT(write)
    return can_socket_find(fd) != NULL ? sendto(fd, buffer, size, 0, (__CONST_SOCKADDR_ARG){NULL}, 0)
                                       : next_write(fd, buffer, size);
}

int sendmmsg(int fd, struct mmsghdr *message, unsigned count, int flags) {
    NEXT(sendmmsg)
    if (can_socket_find(fd) == NULL) {
        return next_sendmmsg(fd, message, count, flags);
    }
    unsigned done = 0;
    while (done < count) {
        const ssize_t bytes = sendmsg(fd, &message[done].msg_hdr, flags);
        if (bytes < 0) {
            break;
        }
        message[done++].msg_len = (unsigned)bytes;
    }
    return done > 0 || count == 0 ? (int)done : -1;
}
