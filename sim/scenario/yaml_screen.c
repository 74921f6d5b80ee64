#include "yaml_screen.h"

#include <stdio.h>
#include <string.h>
#include <yaml.h>

#define MAX_DEPTH 12
#define SHOWN_BYTES 60

typedef struct {
    const char *path;
    char *error;
    size_t error_size;
    int depth;
    int documents;
    bool is_mapping[MAX_DEPTH + 1]; /* true if the collection at this depth is a mapping */
    bool key_is_next[MAX_DEPTH + 1];
} screen_t;

/* Returns the number of bytes before the first character that could move a terminal's cursor or end a line: ASCII
 * control characters, U+0080 to U+009F, U+2028 and U+2029. The text ends with a zero byte. */
static size_t plain_bytes(const yaml_char_t *text, size_t length) {
    for (size_t i = 0; i < length; i++) {
        const bool is_control = text[i] < ' ' || text[i] == 0x7F || (text[i] == 0xC2 && text[i + 1] < 0xA0);
        const bool is_separator = text[i] == 0xE2 && text[i + 1] == 0x80 && (text[i + 2] & 0xFE) == 0xA8;
        if (is_control || is_separator) {
            return i;
        }
    }
    return length;
}

/* Reports that the value is not allowed. mark: text shown before the value, which is "&" for an anchor, "*" for an
 * alias and "" otherwise. */
static bool refuse(const screen_t *self, const yaml_event_t *event, const char *mark, const yaml_char_t *value,
                   const char *expected) {
    size_t shown = plain_bytes(value, strnlen((const char *)value, SHOWN_BYTES));
    while (shown > 0 && (value[shown] & 0xC0) == 0x80) { /* never split a UTF-8 character */
        shown--;
    }
    (void)snprintf(self->error, self->error_size, "%s:%zu: '%s%.*s': expected %s", self->path,
                   event->start_mark.line + 1, mark, (int)shown, (const char *)value, expected);
    return false;
}

/* Reports the line of the parser's problem mark, because the parser's current position is already past the error. */
static bool refuse_syntax(const screen_t *self, const yaml_parser_t *parser) {
    const size_t line = parser->error == YAML_READER_ERROR ? parser->mark.line : parser->problem_mark.line;
    (void)snprintf(self->error, self->error_size, "%s:%zu: expected YAML in UTF-8: %s%s%s", self->path, line + 1,
                   parser->problem != NULL ? parser->problem : "no memory", parser->context != NULL ? " " : "",
                   parser->context != NULL ? parser->context : "");
    return false;
}

/* Records whether the next node of a mapping is a key or a value, because keys and values alternate. Rejects a key that
 * is not a scalar. */
static bool count_node(screen_t *self, const yaml_event_t *event, bool is_scalar) {
    if (!self->is_mapping[self->depth]) {
        return true;
    }
    const bool is_key = self->key_is_next[self->depth];
    self->key_is_next[self->depth] = !is_key;
    return is_scalar || !is_key || refuse(self, event, "", (const yaml_char_t *)"?", "a name as key, not a list");
}

static bool enter(screen_t *self, const yaml_event_t *event, bool is_mapping) {
    if (!count_node(self, event, false)) {
        return false;
    }
    if (self->depth == MAX_DEPTH) {
        return refuse(self, event, "", (const yaml_char_t *)(is_mapping ? "{" : "["), "at most 12 levels of nesting");
    }
    self->depth++;
    self->is_mapping[self->depth] = is_mapping;
    self->key_is_next[self->depth] = true;
    return true;
}

static bool is_plain_node(const screen_t *self, const yaml_event_t *event, const yaml_char_t *anchor,
                          const yaml_char_t *tag) {
    if (anchor != NULL) {
        return refuse(self, event, "&", anchor, "the value alone: anchors are not supported");
    }
    return tag == NULL || refuse(self, event, "", tag, "the value alone: tags are not supported");
}

static bool screen_scalar(screen_t *self, const yaml_event_t *event) {
    if (plain_bytes(event->data.scalar.value, event->data.scalar.length) < event->data.scalar.length) {
        return refuse(self, event, "", event->data.scalar.value, "text in one line, without control characters");
    }
    return is_plain_node(self, event, event->data.scalar.anchor, event->data.scalar.tag) &&
           count_node(self, event, true);
}

static bool screen_event(screen_t *self, const yaml_event_t *event) {
    switch (event->type) {
    case YAML_DOCUMENT_START_EVENT:
        self->documents++;
        return self->documents == 1 || refuse(self, event, "", (const yaml_char_t *)"---", "exactly one document");
    case YAML_ALIAS_EVENT:
        return refuse(self, event, "*", event->data.alias.anchor, "the value itself: aliases are not supported");
    case YAML_SCALAR_EVENT: return screen_scalar(self, event);
    case YAML_SEQUENCE_START_EVENT:
        return is_plain_node(self, event, event->data.sequence_start.anchor, event->data.sequence_start.tag) &&
               enter(self, event, false);
    case YAML_MAPPING_START_EVENT:
        return is_plain_node(self, event, event->data.mapping_start.anchor, event->data.mapping_start.tag) &&
               enter(self, event, true);
    case YAML_SEQUENCE_END_EVENT:
    case YAML_MAPPING_END_EVENT: self->depth--; return true;
    default: return true;
    }
}

bool yaml_screen(const char *path, const char *text, size_t length, char error[], size_t error_size) {
    screen_t self = {.path = path, .error = error, .error_size = error_size};
    yaml_parser_t parser;
    if (yaml_parser_initialize(&parser) == 0) {
        (void)snprintf(error, error_size, "%s: not enough memory to read it", path);
        return false;
    }
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, length);
    bool is_fine = true, is_over = false;
    while (is_fine && !is_over) {
        yaml_event_t event;
        if (yaml_parser_parse(&parser, &event) == 0) {
            is_fine = refuse_syntax(&self, &parser);
            break;
        }
        is_over = event.type == YAML_STREAM_END_EVENT;
        is_fine = screen_event(&self, &event);
        yaml_event_delete(&event);
    }
    yaml_parser_delete(&parser);
    if (is_fine && self.documents == 0) {
        (void)snprintf(error, error_size, "%s:1: expected a scenario: the file is empty", path);
        return false;
    }
    return is_fine;
}
