#include "names.h"

#include <stddef.h>

#include "../firmware/can_protocol.h"

#define LOOK_UP(table, value) ((value) < sizeof(table) / sizeof(table)[0] ? (table)[value] : "unknown")

const char *mode_name(uint8_t mode) {
    static const char *const names[] = {
        [MODE_IDLE] = "idle", [MODE_READY] = "ready", [MODE_COOPERATING] = "cooperating",
        [MODE_HOLD] = "hold", [MODE_FAULT] = "fault",
    };
    return LOOK_UP(names, mode);
}

const char *reason_name(uint8_t reason) {
    static const char *const names[] = {
        [REASON_BOOT] = "boot",
        [REASON_WAITING_FOR_DRIVES] = "waiting_for_drives",
        [REASON_WAITING_FOR_TRACKER] = "waiting_for_tracker",
        [REASON_INPUTS_READY] = "inputs_ready",
        [REASON_OPERATOR_START] = "operator_start",
        [REASON_OPERATOR_STOP] = "operator_stop",
        [REASON_TRACKER_STALE] = "tracker_stale",
        [REASON_TRACKER_RETURNED] = "tracker_returned",
        [REASON_DRIVE_SILENT] = "drive_silent",
        [REASON_DRIVE_ERROR] = "drive_error",
        [REASON_NOT_FINITE] = "not_finite",
        [REASON_FAULT_CLEARED] = "fault_cleared",
    };
    return LOOK_UP(names, reason);
}

const char *result_name(uint8_t result) {
    static const char *const names[] = {
        [RESULT_ACCEPTED] = "accepted",
        [RESULT_WRONG_MODE] = "wrong_mode",
        [RESULT_UNKNOWN_COMMAND] = "unknown_command",
        [RESULT_UNKNOWN_TASK] = "unknown_task",
        [RESULT_NOT_A_UNIT_QUATERNION] = "not_a_unit_quaternion",
        [RESULT_OUT_OF_RANGE] = "out_of_range",
        [RESULT_TRACKER_STALE] = "tracker_stale",
        [RESULT_UNKNOWN_PARAMETER] = "unknown_parameter",
        [RESULT_FAULT_PRESENT] = "fault_present",
    };
    return LOOK_UP(names, result);
}

const char *command_name(uint8_t command) {
    static const char *const names[] = {
        [COMMAND_NONE] = "none", [COMMAND_SELECT] = "select", [COMMAND_START] = "start", [COMMAND_LATCH] = "latch",
        [COMMAND_CLUTCH] = "clutch", [COMMAND_STOP] = "stop", [COMMAND_DEFINE] = "define",
    };
    return LOOK_UP(names, command);
}

const char *task_name(uint8_t task) {
    static const char *const names[] = {
        [TASK_POUR] = "pour", [TASK_TELEOP] = "teleop", [TASK_MIRROR] = "mirror", [TASK_CUSTOM] = "custom",
    };
    return LOOK_UP(names, task);
}
