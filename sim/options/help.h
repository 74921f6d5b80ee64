/* The help text of comanip-sim. */
#ifndef COMANIP_SIM_HELP_H
#define COMANIP_SIM_HELP_H

#include <stdbool.h>
#include <stddef.h>

void help_print(void);

/* Prints the scenarios in the folder. Returns false on failure, with one line in `error`. */
bool help_print_scenarios(const char *folder, char error[], size_t error_size);

#endif
