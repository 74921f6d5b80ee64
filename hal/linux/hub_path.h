/* Finds the hub of a bus: the socket $COMANIP_HUB_DIR/NAME, by default /tmp/comanip-hub-UID/NAME. */
#ifndef COMANIP_HUB_PATH_H
#define COMANIP_HUB_PATH_H

#include <stdbool.h>
#include <stddef.h>

#define HUB_PATH_BYTES 108          /* as in struct sockaddr_un */
#define HUB_SOURCE_SUFFIX ".source" /* suffix of the senders' socket, if other clients may only listen */
#define HUB_LOCK_SUFFIX ".lock"

/* Checks that the name consists of at most 15 letters, digits, '_' and '-', like an interface's name. */
bool hub_name_is_valid(const char *name);

/* Determines the hub folder. On failure, returns false and one line in `error`. */
bool hub_folder(char folder[HUB_PATH_BYTES], char error[], size_t error_size);

/* Returns false, and one line in `error`, unless only this user (or root) can create sockets in the folder. */
bool hub_folder_is_trusted(const char *folder, char error[], size_t error_size);

/* Composes the path, folder/NAME + suffix. On failure, returns false and one line in `error`. */
bool hub_path(char path[HUB_PATH_BYTES], const char *folder, const char *name, const char *suffix, char error[],
              size_t error_size);

/* Connects a socket of AF_UNIX and SOCK_SEQPACKET. Returns 0, or -1 with errno. */
int hub_connect(int fd, const char *path);

/* Connects to the hub NAME in its trusted folder with hub_connect(). On failure, returns false and one line in
 * `error`. */
bool hub_connect_by_name(int fd, const char *name, const char *suffix, char error[], size_t error_size);

#endif
