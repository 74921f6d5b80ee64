/* Parses and formats socketcand's text protocol: see socketcand.h. */
#include "socketcand.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WORDS_MAX (3 + CANFD_MAX_DLEN + 1) /* one word more than the longest command has */
#define STANDARD_ID_DIGITS 3

static const socketcand_command_t malformed = {.kind = SOCKETCAND_MALFORMED};

/* Splits a text at blanks, in place. Returns the number of words, at most WORDS_MAX. */
static int split(char *text, char *word[WORDS_MAX]) {
    int count = 0;
    char *rest = text;
    char *next;
    while (count < WORDS_MAX && (next = strtok_r(rest, " \t\r\n", &rest)) != NULL) {
        word[count++] = next;
    }
    return count;
}

static bool parse_hex(const char *word, size_t digits_max, unsigned long *value) {
    const size_t digits = strlen(word);
    if (digits == 0 || digits > digits_max || strspn(word, "0123456789abcdefABCDEF") != digits) {
        return false;
    }
    *value = strtoul(word, NULL, 16);
    return true;
}

static bool is_frame_length(unsigned long length) {
    static const uint8_t longer[] = {12, 16, 20, 24, 32, 48, 64};
    bool is_one = length <= CAN_MAX_DLEN;
    for (size_t i = 0; i < sizeof longer; i++) {
        is_one = is_one || length == longer[i];
    }
    return is_one;
}

/* Parses `send ID LENGTH BYTE...`. All numbers, including the length, are hexadecimal, as python-can writes them. */
static socketcand_command_t parse_send(char *word[], int count) {
    socketcand_command_t command = {.kind = SOCKETCAND_SEND};
    unsigned long id, length, byte;
    if (count < 3 || !parse_hex(word[1], 8, &id) || !parse_hex(word[2], 2, &length) || !is_frame_length(length) ||
        (unsigned long)count != 3 + length) {
        return malformed;
    }
    const bool is_extended = strlen(word[1]) > STANDARD_ID_DIGITS;
    if (id > (is_extended ? CAN_EFF_MASK : CAN_SFF_MASK)) {
        return malformed;
    }
    for (unsigned long i = 0; i < length; i++) {
        if (!parse_hex(word[3 + i], 2, &byte)) {
            return malformed;
        }
        command.frame.data[i] = (uint8_t)byte;
    }
    const bool is_fd = length > CAN_MAX_DLEN;
    command.frame.can_id = (canid_t)id | (is_extended ? CAN_EFF_FLAG : 0u);
    command.frame.len = (uint8_t)length;
    command.frame.flags = is_fd ? CANFD_BRS | CANFD_FDF : 0;
    command.bytes = is_fd ? CANFD_MTU : CAN_MTU;
    return command;
}

socketcand_command_t socketcand_parse(const char *text, size_t length) {
    char copy[SOCKETCAND_COMMAND_BYTES + 1];
    char *word[WORDS_MAX];
    if (length >= sizeof copy || memchr(text, '\0', length) != NULL) {
        return malformed;
    }
    memcpy(copy, text, length);
    copy[length] = '\0';
    const int count = split(copy, word);
    socketcand_command_t command = malformed;
    if (count == 2 && strcmp(word[0], "open") == 0 && strlen(word[1]) < sizeof command.bus) {
        command.kind = SOCKETCAND_OPEN;
        (void)strcpy(command.bus, word[1]);
    } else if (count == 1 && strcmp(word[0], "rawmode") == 0) {
        command.kind = SOCKETCAND_RAWMODE;
    } else if (count == 1 && strcmp(word[0], "echo") == 0) {
        command.kind = SOCKETCAND_ECHO;
    } else if (count >= 1 && strcmp(word[0], "send") == 0) {
        command = parse_send(word, count);
    }
    return command;
}

size_t socketcand_format(const journal_entry_t *entry, char line[SOCKETCAND_LINE_BYTES]) {
    static const char hex[] = "0123456789ABCDEF";
    const struct canfd_frame *frame = &entry->frame;
    const bool is_error = (frame->can_id & CAN_ERR_FLAG) != 0;
    if (!is_error && (frame->can_id & CAN_RTR_FLAG) != 0) {
        return 0;
    }
    const int digits = (frame->can_id & (CAN_EFF_FLAG | CAN_ERR_FLAG)) != 0 ? 8 : STANDARD_ID_DIGITS;
    const int head = snprintf(line, SOCKETCAND_LINE_BYTES, "< %s %0*X %lld.%06ld ", is_error ? "error" : "frame",
                              digits, frame->can_id & (is_error ? CAN_EFF_MASK | CAN_ERR_FLAG : CAN_EFF_MASK),
                              (long long)entry->time.tv_sec, entry->time.tv_nsec / 1000);
    char *end = line + head;
    for (int i = 0; i < frame->len && !is_error; i++) {
        *end++ = hex[frame->data[i] >> 4];
        *end++ = hex[frame->data[i] & 0xF];
    }
    if (end[-1] != ' ') {
        *end++ = ' ';
    } else if (!is_error) { /* an empty frame: python-can expects a third word, which may be empty */
        *end++ = ' ';
    }
    *end++ = '>';
    return (size_t)(end - line);
}
