/* The protocol of socketcand. Commands are between '<' and '>'. Frames have the form
 * `< frame 123 1700000000.123456 DEADBEEF >`.
 *
 * The protocol has no notation for CAN FD that python-can understands. CAN FD frames are therefore written like classic
 * frames, but with up to 64 bytes, which python-can and cantools accept. A command to send more than 8 bytes sends a
 * CAN FD frame with bit rate switch. All data and ids are preserved, but the CAN FD flag of a frame with up to 8 bytes
 * is lost. Remote frames would look like empty data frames, so they are left out. */
#ifndef COMANIP_HUB_SOCKETCAND_H
#define COMANIP_HUB_SOCKETCAND_H

#include <stddef.h>

#include "journal.h"

#define SOCKETCAND_LINE_BYTES 200 /* python-can discards longer lines */
/* Every line is padded with leading blanks to this size. python-can reads 1024 bytes at a time, which is a multiple of
 * this size. If a read ended within a line, python-can would print a warning, which would disturb the display of
 * cantools monitor. */
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
    char bus[16];             /* for SOCKETCAND_OPEN */
    struct canfd_frame frame; /* for SOCKETCAND_SEND */
    size_t bytes;             /* CAN_MTU or CANFD_MTU */
} socketcand_command_t;

/* Parses a command. text: the characters between '<' and '>'. */
socketcand_command_t socketcand_parse(const char *text, size_t length);

/* Writes the line for a frame, without a newline. Returns its length, or 0 if the protocol cannot carry the frame. */
size_t socketcand_format(const journal_entry_t *entry, char line[SOCKETCAND_LINE_BYTES]);

#endif
