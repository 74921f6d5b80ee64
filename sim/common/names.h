/* These functions return the DBC's names of modes, reasons, results, commands, tasks and CAN states, or "unknown" for a
 * number that the DBC does not name. */
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
