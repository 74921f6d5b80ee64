#include "names.h"

#include "comanip_schema.h"

#define LOOK_UP(table, value) ((value) < sizeof(table) / sizeof(table)[0] ? (table)[value] : "unknown")

const char *mode_name(uint8_t mode) {
    static const char *const names[] = {COMANIP_FIRMWARE_STATUS_MODE_NAMES};
    return LOOK_UP(names, mode);
}

const char *reason_name(uint8_t reason) {
    static const char *const names[] = {COMANIP_FIRMWARE_STATUS_REASON_NAMES};
    return LOOK_UP(names, reason);
}

const char *result_name(uint8_t result) {
    static const char *const names[] = {COMANIP_COMMAND_ACK_RESULT_NAMES};
    return LOOK_UP(names, result);
}

const char *command_name(uint8_t command) {
    static const char *const names[] = {COMANIP_COMMAND_ACK_COMMAND_NAMES};
    return LOOK_UP(names, command);
}

const char *task_name(uint8_t task) {
    static const char *const names[] = {COMANIP_FIRMWARE_STATUS_TASK_NAMES};
    return LOOK_UP(names, task);
}

const char *can_state_name(uint8_t state) {
    static const char *const names[] = {COMANIP_PORT_STATUS_CAN_STATE_NAMES};
    return LOOK_UP(names, state);
}
