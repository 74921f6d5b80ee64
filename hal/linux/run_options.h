/* Options shared by comanip-firmware and comanip-plant, which run on a real bus: its name and the time scale. */
#ifndef COMANIP_RUN_OPTIONS_H
#define COMANIP_RUN_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "../../firmware/protocol/can_profile.h"

typedef struct {
    const char *can; /* name of the bus; NULL if not given */
    uint32_t slow;   /* time scale: see pace.h */
} run_options_t;

/* Removes --can NAME and --slow N from the arguments, at any position, keeps the others in order, and sets *argc to
 * their number. On failure, returns false and one line in `error`. */
bool run_options_take(run_options_t *self, int *argc, char *argv[], char error[], size_t error_size);

/* Does the same for --profile fd|classic. Only comanip-firmware calls this; comanip-plant parses --profile with the
 * simulator's options. */
bool run_options_take_profile(can_profile_t *profile, int *argc, char *argv[], char error[], size_t error_size);

/* Returns true if argv[*index] is this option, as "--name value" or "--name=value". Moves *index to the option's last
 * argument, and sets *value to its value, or to NULL if it has none. */
bool run_options_is(const char *name, int argc, char *argv[], int *index, const char **value);

#endif
