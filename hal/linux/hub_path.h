/* Where the hub of a bus is found: the socket $COMANIP_HUB_DIR/NAME, /tmp/comanip-hub-UID/NAME by default. */
#ifndef COMANIP_HUB_PATH_H
#define COMANIP_HUB_PATH_H

#include <stdbool.h>
#include <stddef.h>

#define HUB_PATH_BYTES 108          /* as in struct sockaddr_un */
#define HUB_SOURCE_SUFFIX ".source" /* of the socket for the clients that may send, if all others may only listen */
#define HUB_LOCK_SUFFIX ".lock"

/* Letters, digits, '_' and '-', at most 15, as an interface's name. */
bool hub_name_is_valid(const char *name);

/* The folder. On failure false, and one line in `error`. */
bool hub_folder(char folder[HUB_PATH_BYTES], char error[], size_t error_size);

/* False, and one line in `error`, unless only this user (or root) can put sockets there. */
bool hub_folder_is_trusted(const char *folder, char error[], size_t error_size);

/* folder/NAME + suffix. On failure false, and one line in `error`. */
bool hub_path(char path[HUB_PATH_BYTES], const char *folder, const char *name, const char *suffix, char error[],
              size_t error_size);

/* Connects a socket of AF_UNIX and SOCK_SEQPACKET. Gives 0, or -1 with errno. */
int hub_connect(int fd, const char *path);

/* hub_connect() to the hub NAME in its trusted folder. On failure false, and one line in `error`. */
bool hub_connect_by_name(int fd, const char *name, const char *suffix, char error[], size_t error_size);

#endif
