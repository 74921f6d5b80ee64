#include "yaml_choice.h"

#include <stdio.h>
#include <string.h>

#define WORD_BYTES 64
#define LIST_BYTES 1200
#define SHORT_LIST_BYTES 60
#define SIMILAR_SHARE 3   /* two words are similar if at most 1 / SIMILAR_SHARE of the letters differ */
#define SIMILAR_LETTERS 2 /* they are also similar if at most SIMILAR_LETTERS letters differ */

int yaml_choice(const char *word, const char *const words[]) {
    for (int i = 0; words[i] != NULL; i++) {
        if (strcmp(word, words[i]) == 0) {
            return i;
        }
    }
    return -1;
}

static size_t least(size_t a, size_t b) {
    return a < b ? a : b;
}

/* Returns the Levenshtein distance of two words: how many letters must be inserted, removed or replaced to turn one
 * word into the other. */
static size_t edit_distance(const char *a, const char *b) {
    size_t row[WORD_BYTES];
    const size_t length = strnlen(b, WORD_BYTES - 1);
    for (size_t j = 0; j <= length; j++) {
        row[j] = j;
    }
    for (size_t i = 1; a[i - 1] != '\0'; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= length; j++) {
            const size_t above = row[j];
            row[j] = least(least(above, row[j - 1]) + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1));
            diagonal = above;
        }
    }
    return row[length];
}

/* Returns the most similar word of the list, or NULL if no word is similar. */
static const char *most_similar(const char *word, const char *const words[]) {
    const size_t length = strlen(word);
    size_t best = (length / SIMILAR_SHARE > SIMILAR_LETTERS ? length / SIMILAR_SHARE : SIMILAR_LETTERS) + 1;
    const char *similar = NULL;
    for (size_t i = 0; length < WORD_BYTES && words[i] != NULL; i++) {
        const size_t distance = edit_distance(word, words[i]);
        if (distance < best && distance < length) { /* a word is not similar if every letter would be replaced */
            best = distance;
            similar = words[i];
        }
    }
    return similar;
}

/* Writes "a, b, c", truncated to fit. Returns the number of words. */
static size_t list_words(const char *const words[], char list[LIST_BYTES]) {
    size_t count = 0, used = 0;
    list[0] = '\0';
    for (; words[count] != NULL; count++) {
        if (used + strlen(words[count]) + sizeof ", , ..." < LIST_BYTES) {
            used += (size_t)snprintf(list + used, LIST_BYTES - used, "%s%s", count > 0 ? ", " : "", words[count]);
        } else if (strcmp(list + used - 3, "...") != 0) {
            used += (size_t)snprintf(list + used, LIST_BYTES - used, ", ...");
        }
    }
    return count;
}

void yaml_refuse_choice(yaml_reader_t *self, const yaml_node_t *node, const char *what, const char *const words[]) {
    char list[LIST_BYTES];
    const size_t count = list_words(words, list);
    const char *similar = most_similar(yaml_scalar(node), words);
    if (count == 0) {
        yaml_refuse(self, node, "one of the %s: there are none", what);
    } else if (similar == NULL) {
        yaml_refuse(self, node, "one of the %s %s", what, list);
    } else if (strlen(list) <= SHORT_LIST_BYTES) {
        yaml_refuse(self, node, "one of the %s %s; did you mean %s?", what, list, similar);
    } else {
        yaml_refuse(self, node, "one of the %zu %s; did you mean %s?", count, what, similar);
    }
}

void yaml_check_keys(yaml_reader_t *self, yaml_node_t *map, const char *const keys[]) {
    yaml_expect_mapping(self, map);
    yaml_node_t *key, *value;
    for (size_t i = 0; yaml_entry(self, map, i, &key, &value); i++) {
        if (yaml_choice(yaml_scalar(key), keys) < 0) {
            yaml_refuse_choice(self, key, "keys", keys);
        }
    }
}
