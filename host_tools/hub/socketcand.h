/* The language of socketcand: commands between '<' and '>', frames as `< frame 123 1700000000.123456 DEADBEEF >`.
 *
 * It has no word for CAN FD that python-can reads. A frame of CAN FD is written as any other, with up to 64 bytes,
 * which python-can and cantools take; a command to send more than 8 bytes makes a frame of CAN FD with bit rate switch.
 * So all data and ids come through, and only the mark of CAN FD on a frame of up to 8 bytes is lost. Remote frames
 * cannot be told from empty ones and are left out. */
#ifndef COMANIP_HUB_SOCKETCAND_H
#define COMANIP_HUB_SOCKETCAND_H

#include <stddef.h>

#include "journal.h"

#define SOCKETCAND_LINE_BYTES 200 /* python-can throws away what is longer */
/* With blanks before it, every line takes so much: python-can reads 1024 bytes at a time, and complains of a line that
 * is cut, on the terminal where cantools monitor draws. */
#define SOCKETCAND_PADDED_BYTES 256
#define SOCKETCAND_COMMAND_BYTES 256

typedef enum {
    SOCKETCAND_OPEN,
    SOCKETCAND_RAWMODE,
    SOCKETCAND_ECHO,
    SOCKETCAND_SEND,
    SOCKETCAND_MALFORMED,
} socketcand_kind_t;

typedef struct {
    socketcand_kind_t kind;
    char bus[16];             /* of SOCKETCAND_OPEN */
    struct canfd_frame frame; /* of SOCKETCAND_SEND */
    size_t bytes;             /* CAN_MTU or CANFD_MTU */
} socketcand_command_t;

/* What stands between '<' and '>', both left out. */
socketcand_command_t socketcand_parse(const char *text, size_t length);

/* The line for a frame, without a newline. Gives its length; 0 if the language cannot carry it. */
size_t socketcand_format(const journal_entry_t *entry, char line[SOCKETCAND_LINE_BYTES]);

#endif
