/* Writes a log in the format of `candump -L`. Lines are formatted without printf(): at 7 frames per simulated ms,
 * printf() would take more time than any other part of the simulator. */
#include "candump_log.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BUFFER_BYTES (1 << 16)
/* Longest line: "(0000000000.000000) vcan0 123##1", 64 bytes in hex, newline. A classic frame has one # and up to 8
 * bytes. */
#define LINE_BYTES (32 + 2 * CAN_FRAME_MAX_BYTES + 1)

struct candump_log {
    FILE *file;
    const char *path;
    int error_number; /* errno of the first failed write, else 0 */
};

candump_log_t *candump_log_open(const char *path, char error[], size_t error_size) {
    candump_log_t *self = malloc(sizeof *self);
    if (self == NULL) {
        (void)snprintf(error, error_size, "%s: not enough memory to write a log", path);
        return NULL;
    }
    *self = (candump_log_t){.file = fopen(path, "w"), .path = path};
    if (self->file == NULL) {
        (void)snprintf(error, error_size, "%s: cannot be written: %s", path, strerror(errno));
        free(self);
        return NULL;
    }
    (void)setvbuf(self->file, NULL, _IOFBF, BUFFER_BYTES);
    return self;
}

static char *put_decimal(char *end, uint64_t value, int digits) {
    for (int i = digits - 1; i >= 0; i--) {
        end[i] = (char)('0' + value % 10U);
        value /= 10U;
    }
    return end + digits;
}

static char *put_text(char *end, const char *text, size_t length) {
    memcpy(end, text, length);
    return end + length;
}

void candump_log_write(candump_log_t *self, const can_frame_t *frame, int64_t end_ns) {
    static const char hex[] = "0123456789ABCDEF";
    const uint64_t end_us = (uint64_t)end_ns / 1000U;
    char line[LINE_BYTES];
    char *end = line;

    *end++ = '(';
    end = put_decimal(end, end_us / 1000000U, 10);
    *end++ = '.';
    end = put_decimal(end, end_us % 1000000U, 6);
    end = put_text(end, ") vcan0 ", 8);
    *end++ = hex[(frame->id >> 8) & 0xFU];
    *end++ = hex[(frame->id >> 4) & 0xFU];
    *end++ = hex[frame->id & 0xFU];
    end = frame->fd ? put_text(end, "##1", 3) : put_text(end, "#", 1); /* ##1: CAN FD with bit rate switch */
    for (int i = 0; i < frame->length; i++) {
        *end++ = hex[frame->data[i] >> 4];
        *end++ = hex[frame->data[i] & 0xFU];
    }
    *end++ = '\n';

    const size_t length = (size_t)(end - line);
    if (self->error_number == 0 && fwrite(line, 1, length, self->file) != length) {
        self->error_number = errno;
    }
}

bool candump_log_close(candump_log_t *self, char error[], size_t error_size) {
    if (fclose(self->file) != 0 && self->error_number == 0) {
        self->error_number = errno;
    }
    const bool complete = self->error_number == 0;
    if (!complete) {
        (void)snprintf(error, error_size, "%s: the log is incomplete: %s", self->path, strerror(self->error_number));
    }
    free(self);
    return complete;
}
