#include "run_options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pace.h"

bool run_options_is(const char *name, int argc, char *argv[], int *index, const char **value) {
    const size_t length = strlen(name);
    const char *argument = argv[*index];
    if (strncmp(argument, name, length) != 0 || (argument[length] != '\0' && argument[length] != '=')) {
        return false;
    }
    if (argument[length] == '=') {
        *value = argument + length + 1;
    } else {
        *value = *index + 1 < argc ? argv[++*index] : NULL;
    }
    return true;
}

static bool read_slow(const char *text, uint32_t *slow) {
    char *end = NULL;
    const unsigned long value = strtoul(text, &end, 10);
    *slow = (uint32_t)value;
    return text[0] >= '0' && text[0] <= '9' && *end == '\0' && value >= 1 && value <= PACE_SLOW_MAX;
}

bool run_options_take(run_options_t *self, int *argc, char *argv[], char error[], size_t error_size) {
    *self = (run_options_t){.slow = 1};
    int left = 1;
    for (int i = 1; i < *argc; i++) {
        const char *value = NULL;
        if (run_options_is("--can", *argc, argv, &i, &value)) {
            self->can = value;
            if (value == NULL || value[0] == '\0') {
                (void)snprintf(error, error_size, "--can '': expected the name of a CAN interface, for example vcan0");
                return false;
            }
        } else if (run_options_is("--slow", *argc, argv, &i, &value)) {
            if (value == NULL || !read_slow(value, &self->slow)) {
                (void)snprintf(error, error_size, "--slow '%.100s': expected a whole number from 1 to %u",
                               value != NULL ? value : "", PACE_SLOW_MAX);
                return false;
            }
        } else {
            argv[left++] = argv[i];
        }
    }
    argv[left] = NULL;
    *argc = left;
    return true;
}

bool run_options_take_profile(can_profile_t *profile, int *argc, char *argv[], char error[], size_t error_size) {
    int left = 1;
    for (int i = 1; i < *argc; i++) {
        const char *value = NULL;
        if (!run_options_is("--profile", *argc, argv, &i, &value)) {
            argv[left++] = argv[i];
            continue;
        }
        const bool is_classic = value != NULL && strcmp(value, "classic") == 0;
        if (!is_classic && (value == NULL || strcmp(value, "fd") != 0)) {
            (void)snprintf(error, error_size, "--profile '%.100s': expected fd or classic", value != NULL ? value : "");
            return false;
        }
        *profile = is_classic ? CAN_PROFILE_CLASSIC : CAN_PROFILE_FD;
    }
    argv[left] = NULL;
    *argc = left;
    return true;
}
