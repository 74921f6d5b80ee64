/* What comanip-sim says about itself. */
#ifndef COMANIP_SIM_HELP_H
#define COMANIP_SIM_HELP_H

#include <stdbool.h>
#include <stddef.h>

void help_print(void);

/* The scenarios in the folder. On failure false, and one line in `error`. */
bool help_print_scenarios(const char *folder, char error[], size_t error_size);

#endif
