/* Names of modes, reasons, results, commands and tasks as in the DBC; "unknown" for a number without a name there. */
#ifndef COMANIP_SIM_NAMES_H
#define COMANIP_SIM_NAMES_H

#include <stdint.h>

const char *mode_name(uint8_t mode);
const char *reason_name(uint8_t reason);
const char *result_name(uint8_t result);
const char *command_name(uint8_t command);
const char *task_name(uint8_t task);
const char *can_state_name(uint8_t state);

#endif
