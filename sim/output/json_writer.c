#include "json_writer.h"

#include <inttypes.h>
#include <math.h>
#include <stddef.h>

/* Returns the length in bytes of the well-formed UTF-8 sequence at `text` (RFC 3629); 0 if there is none. */
static int utf8_length(const unsigned char *text) {
    const unsigned char c = text[0];
    if (c < 0x80) {
        return 1;
    }
    const int length = c >= 0xC2 && c <= 0xDF ? 2 : c >= 0xE0 && c <= 0xEF ? 3 : c >= 0xF0 && c <= 0xF4 ? 4 : 0;
    for (int i = 1; i < length; i++) {
        if ((text[i] & 0xC0) != 0x80) {
            return 0;
        }
    }
    const bool overlong = (c == 0xE0 && text[1] < 0xA0) || (c == 0xF0 && text[1] < 0x90);
    const bool surrogate = c == 0xED && text[1] > 0x9F;
    const bool too_large = c == 0xF4 && text[1] > 0x8F;
    return overlong || surrogate || too_large ? 0 : length;
}

static void write_string(FILE *file, const char *value) {
    (void)fputc('"', file);
    const unsigned char *text = (const unsigned char *)value;
    while (*text != '\0') {
        const int length = utf8_length(text);
        if (length == 0) {
            (void)fputs("\\ufffd", file);
            text++;
        } else if (*text == '"' || *text == '\\') {
            (void)fprintf(file, "\\%c", *text++);
        } else if (*text < 0x20) {
            (void)fprintf(file, "\\u%04x", *text++);
        } else {
            (void)fwrite(text, 1, (size_t)length, file);
            text += length;
        }
    }
    (void)fputc('"', file);
}

static void begin_member(json_writer_t *self, const char *key) {
    if (self->has_member) {
        (void)fputc(',', self->file);
    }
    if (self->depth > 0) {
        (void)fprintf(self->file, "\n%*s", 2 * self->depth, "");
    }
    if (key != NULL) {
        write_string(self->file, key);
        (void)fputs(": ", self->file);
    }
    self->has_member = true;
}

void json_begin(json_writer_t *self, const char *key, char bracket) {
    begin_member(self, key);
    (void)fputc(bracket, self->file);
    self->depth++;
    self->has_member = false;
}

void json_end(json_writer_t *self, char bracket) {
    self->depth--;
    if (self->has_member) {
        (void)fprintf(self->file, "\n%*s", 2 * self->depth, "");
    }
    (void)fputc(bracket, self->file);
    self->has_member = true;
}

void json_text(json_writer_t *self, const char *key, const char *value) {
    begin_member(self, key);
    write_string(self->file, value);
}

void json_unsigned(json_writer_t *self, const char *key, uint64_t value) {
    begin_member(self, key);
    (void)fprintf(self->file, "%" PRIu64, value);
}

void json_bool(json_writer_t *self, const char *key, bool value) {
    begin_member(self, key);
    (void)fputs(value ? "true" : "false", self->file);
}

void json_null(json_writer_t *self, const char *key) {
    begin_member(self, key);
    (void)fputs("null", self->file);
}

void json_number(json_writer_t *self, const char *key, double value) {
    begin_member(self, key);
    if (isfinite(value)) {
        (void)fprintf(self->file, "%.9g", value);
    } else {
        (void)fputs("null", self->file);
    }
}
