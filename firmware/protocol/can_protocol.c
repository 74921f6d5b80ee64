#include "can_protocol.h"

#include <stddef.h>
#include <string.h>

#include "../maths/float_bits.h"
#include "comanip_dbc.h"
#include "comanip_schema.h"

#define FRAME_ROW(name, id, bytes, data_id, period_ms, timeout_ms, to_firmware)                                        \
    [FRAME_##name] = {id, bytes, data_id, period_ms, timeout_ms, to_firmware},
const frame_description_t frame_table[FRAME_KIND_COUNT] = {COMANIP_FRAMES(FRAME_ROW)};

#define COUNT_ROW(name, id, bytes, data_id, period_ms, timeout_ms, to_firmware) +1
_Static_assert(FRAME_KIND_COUNT == 0 COMANIP_FRAMES(COUNT_ROW), "the DBC has other frames than frame_kind_t");

static bool is_authentic(protocol_receiver_t *self, const can_frame_t *frame, frame_kind_t kind) {
    const frame_description_t *description = &frame_table[kind];
    if (description->data_id == 0u) {
        return true;
    }
    e2e_status_t status = e2e_check(&self->e2e[kind], frame->data, frame->length, description->data_id);
    return status >= 0 || (status == E2E_WRONG_SEQUENCE && description->period_ms == 0u);
}

bool protocol_find(uint16_t id, frame_kind_t *kind) {
#define ID_CASE(name, id, bytes, data_id, period_ms, timeout_ms, to_firmware)                                          \
    case id: *kind = FRAME_##name; return true;
    switch (id) { /* the compiler searches faster than a loop over the table */
        COMANIP_FRAMES(ID_CASE)
    default: return false;
    }
}

void protocol_protect(protocol_sender_t *self, can_frame_t *frame) {
    frame_kind_t kind;
    if (protocol_find(frame->id, &kind) && frame_table[kind].data_id != 0u) {
        e2e_protect(frame->data, frame->length, frame_table[kind].data_id, self->counter[kind]++);
    }
}

protocol_status_t protocol_check(protocol_receiver_t *self, const can_frame_t *frame, frame_kind_t kind) {
    protocol_status_t status = PROTOCOL_OK;
    if (frame->length != frame_table[kind].length) {
        status = PROTOCOL_WRONG_LENGTH;
    } else if (!is_authentic(self, frame, kind)) {
        status = PROTOCOL_NOT_AUTHENTIC;
    }
    self->rejected += status != PROTOCOL_OK;
    return status;
}

/* A frame of this kind: the generated packing writes all of its data. */
static void begin(can_frame_t *frame, frame_kind_t kind) {
    frame->timestamp_us = 0;
    frame->id = frame_table[kind].id;
    frame->length = frame_table[kind].length;
    frame->fd = true;
}

/* Rounds to nearest. If the signal cannot carry the value, NaN included: 0, and *fits becomes false. */
static int32_t quantise(float value, float per_unit, int32_t minimum, int32_t maximum, bool *fits) {
    if (float_magnitude_bits(value) == 0u) { /* what a smaller arm's joints leave empty: most of a JointCmd */
        return 0;
    }
    const float scaled = value * per_unit;
    const uint32_t magnitude = float_magnitude_bits(scaled);
    const bool is_negative = float_is_negative(scaled);
    const bool fits_either_way = magnitude <= float_magnitude_bits((float)maximum) && (minimum != 0 || !is_negative);
    if (fits_either_way || (is_negative && magnitude <= float_magnitude_bits((float)minimum))) {
        return float_nearest(scaled); /* raw values have 24 bits at most: the code generator checks it */
    }
    *fits = false;
    return 0;
}

#define QUANTISE(fits, value, SIGNAL)                                                                                  \
    quantise((value), COMANIP_##SIGNAL##_PER_UNIT, COMANIP_##SIGNAL##_RAW_MIN, COMANIP_##SIGNAL##_RAW_MAX, &(fits))

/* The raw value goes into `raw_member`, of the C type `raw_type`. */
#define PACK(fits, value, SIGNAL, raw_type, raw_member) ((raw_member) = (raw_type)QUANTISE(fits, value, SIGNAL))

#define UNPACK(SIGNAL, raw) ((float)(raw) * COMANIP_##SIGNAL##_RESOLUTION)

static protocol_status_t status_of(bool fits) {
    return fits ? PROTOCOL_OK : PROTOCOL_OUT_OF_RANGE;
}

protocol_status_t hand_pose_pack(const hand_pose_t *message, can_frame_t *frame) {
    struct comanip_hand_pose_t raw = {.t_us = message->t_us, .valid = message->valid};
    bool fits = true;
    PACK(fits, message->position_m.x, HAND_POSE_X_M, int32_t, raw.x_m);
    PACK(fits, message->position_m.y, HAND_POSE_Y_M, int32_t, raw.y_m);
    PACK(fits, message->position_m.z, HAND_POSE_Z_M, int32_t, raw.z_m);
    PACK(fits, message->rotation.w, HAND_POSE_QW, int32_t, raw.qw);
    PACK(fits, message->rotation.x, HAND_POSE_QX, int32_t, raw.qx);
    PACK(fits, message->rotation.y, HAND_POSE_QY, int32_t, raw.qy);
    PACK(fits, message->rotation.z, HAND_POSE_QZ, int32_t, raw.qz);
    if (!fits) {
        raw = (struct comanip_hand_pose_t){.t_us = message->t_us, .valid = 0};
    }
    begin(frame, FRAME_HAND_POSE);
    (void)comanip_hand_pose_pack(frame->data, &raw, frame->length);
    return status_of(fits);
}

void hand_pose_unpack(const can_frame_t *frame, hand_pose_t *message) {
    struct comanip_hand_pose_t raw;
    (void)comanip_hand_pose_unpack(&raw, frame->data, frame->length);
    *message = (hand_pose_t){
        .t_us = raw.t_us,
        .position_m = {UNPACK(HAND_POSE_X_M, raw.x_m), UNPACK(HAND_POSE_Y_M, raw.y_m), UNPACK(HAND_POSE_Z_M, raw.z_m)},
        .rotation = {UNPACK(HAND_POSE_QW, raw.qw), UNPACK(HAND_POSE_QX, raw.qx), UNPACK(HAND_POSE_QY, raw.qy),
                     UNPACK(HAND_POSE_QZ, raw.qz)},
        .valid = raw.valid != 0u,
    };
}

protocol_status_t tracker_status_pack(const tracker_status_t *message, can_frame_t *frame) {
    struct comanip_tracker_status_t raw = {
        .t_us = message->t_us,
        .fault = message->fault,
        .lost_samples = message->lost_samples,
        .range_errors = message->range_errors,
    };
    bool fits = true;
    PACK(fits, (float)message->period_us, TRACKER_STATUS_PERIOD_US, uint16_t, raw.period_us);
    PACK(fits, (float)message->latency_us, TRACKER_STATUS_LATENCY_US, uint16_t, raw.latency_us);
    begin(frame, FRAME_TRACKER_STATUS);
    (void)comanip_tracker_status_pack(frame->data, &raw, frame->length);
    return status_of(fits);
}

void tracker_status_unpack(const can_frame_t *frame, tracker_status_t *message) {
    struct comanip_tracker_status_t raw;
    (void)comanip_tracker_status_unpack(&raw, frame->data, frame->length);
    *message = (tracker_status_t){
        .t_us = raw.t_us,
        .period_us = 10u * (uint32_t)raw.period_us,
        .latency_us = 10u * (uint32_t)raw.latency_us,
        .fault = raw.fault,
        .lost_samples = raw.lost_samples,
        .range_errors = raw.range_errors,
    };
}

/* The DBC has no arrays: the eight joints of JointCmd by their numbers. */
#define FOR_EACH_JOINT(X) X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7)

protocol_status_t joint_command_pack(const joint_command_t *message, can_frame_t *frame) {
    struct comanip_joint_cmd_t raw; /* all of it is set below: an initialiser would first write zeros */
    int32_t position[ARM_MAX_JOINTS], velocity[ARM_MAX_JOINTS], torque[ARM_MAX_JOINTS];
    bool fits = true;
    for (int i = 0; i < ARM_MAX_JOINTS; i++) { /* all joints are scaled as joint 0: the code generator checks it */
        position[i] = QUANTISE(fits, message->position_rad[i], JOINT_CMD_POSITION_0_RAD);
        velocity[i] = QUANTISE(fits, message->velocity_radps[i], JOINT_CMD_VELOCITY_0_RADPS);
        torque[i] = QUANTISE(fits, message->torque_Nm[i], JOINT_CMD_TORQUE_0_NM);
    }
#define PACK_JOINT(i)                                                                                                  \
    raw.mode_##i = (uint8_t)message->mode[i];                                                                          \
    raw.position_##i##_rad = position[i];                                                                              \
    raw.velocity_##i##_radps = (int16_t)velocity[i];                                                                   \
    raw.torque_##i##_nm = (int16_t)torque[i];
    FOR_EACH_JOINT(PACK_JOINT)
    raw.e2e_crc = 0; /* e2e_protect()'s, as the counter */
    raw.e2e_counter = 0;
    begin(frame, FRAME_JOINT_CMD);
    (void)comanip_joint_cmd_pack(frame->data, &raw, frame->length);
    return status_of(fits);
}

void joint_command_unpack(const can_frame_t *frame, joint_command_t *message) {
    struct comanip_joint_cmd_t raw;
    (void)comanip_joint_cmd_unpack(&raw, frame->data, frame->length);
#define UNPACK_JOINT(i)                                                                                                \
    message->mode[i] = (drive_mode_t)raw.mode_##i;                                                                     \
    message->position_rad[i] = UNPACK(JOINT_CMD_POSITION_##i##_RAD, raw.position_##i##_rad);                           \
    message->velocity_radps[i] = UNPACK(JOINT_CMD_VELOCITY_##i##_RADPS, raw.velocity_##i##_radps);                     \
    message->torque_Nm[i] = UNPACK(JOINT_CMD_TORQUE_##i##_NM, raw.torque_##i##_nm);
    FOR_EACH_JOINT(UNPACK_JOINT)
}

/* JointState0 stands for all eight: the code generator checks that their layouts are one. */
protocol_status_t joint_state_pack(int joint, const joint_state_t *message, can_frame_t *frame) {
    struct comanip_joint_state0_t raw = {
        .mode = (uint8_t)message->mode,
        .error = (uint8_t)message->error,
        .temperature_deg_c = message->temperature_degC,
    };
    bool fits = true;
    PACK(fits, message->position_rad, JOINT_STATE0_POSITION_RAD, int32_t, raw.position_rad);
    PACK(fits, message->velocity_radps, JOINT_STATE0_VELOCITY_RADPS, int16_t, raw.velocity_radps);
    PACK(fits, message->torque_Nm, JOINT_STATE0_TORQUE_NM, int16_t, raw.torque_nm);
    begin(frame, (frame_kind_t)(FRAME_JOINT_STATE0 + joint));
    (void)comanip_joint_state0_pack(frame->data, &raw, frame->length);
    return status_of(fits);
}

void joint_state_unpack(const can_frame_t *frame, joint_state_t *message) {
    struct comanip_joint_state0_t raw;
    (void)comanip_joint_state0_unpack(&raw, frame->data, frame->length);
    *message = (joint_state_t){
        .position_rad = UNPACK(JOINT_STATE0_POSITION_RAD, raw.position_rad),
        .velocity_radps = UNPACK(JOINT_STATE0_VELOCITY_RADPS, raw.velocity_radps),
        .torque_Nm = UNPACK(JOINT_STATE0_TORQUE_NM, raw.torque_nm),
        .mode = (drive_mode_t)raw.mode,
        .error = (drive_error_t)raw.error,
        .temperature_degC = raw.temperature_deg_c,
    };
}

protocol_status_t operator_command_pack(const operator_command_t *message, can_frame_t *frame) {
    struct comanip_operator_command_t raw = {
        .command = message->command, .sequence = message->sequence, .task = message->task};
    begin(frame, FRAME_OPERATOR_COMMAND);
    (void)comanip_operator_command_pack(frame->data, &raw, frame->length);
    return PROTOCOL_OK;
}

void operator_command_unpack(const can_frame_t *frame, operator_command_t *message) {
    struct comanip_operator_command_t raw;
    (void)comanip_operator_command_unpack(&raw, frame->data, frame->length);
    *message = (operator_command_t){.command = raw.command, .sequence = raw.sequence, .task = raw.task};
}

protocol_status_t task_define_pack(const task_define_t *message, can_frame_t *frame) {
    struct comanip_task_define_t raw = {.sequence = message->sequence, .form = message->form};
    bool fits = true;
    PACK(fits, message->t_task_m.x, TASK_DEFINE_T_TASK_X_M, int32_t, raw.t_task_x_m);
    PACK(fits, message->t_task_m.y, TASK_DEFINE_T_TASK_Y_M, int32_t, raw.t_task_y_m);
    PACK(fits, message->t_task_m.z, TASK_DEFINE_T_TASK_Z_M, int32_t, raw.t_task_z_m);
    PACK(fits, message->q_task.w, TASK_DEFINE_Q_TASK_W, int16_t, raw.q_task_w);
    PACK(fits, message->q_task.x, TASK_DEFINE_Q_TASK_X, int16_t, raw.q_task_x);
    PACK(fits, message->q_task.y, TASK_DEFINE_Q_TASK_Y, int16_t, raw.q_task_y);
    PACK(fits, message->q_task.z, TASK_DEFINE_Q_TASK_Z, int16_t, raw.q_task_z);
    PACK(fits, message->q_inv.w, TASK_DEFINE_Q_INV_W, int16_t, raw.q_inv_w);
    PACK(fits, message->q_inv.x, TASK_DEFINE_Q_INV_X, int16_t, raw.q_inv_x);
    PACK(fits, message->q_inv.y, TASK_DEFINE_Q_INV_Y, int16_t, raw.q_inv_y);
    PACK(fits, message->q_inv.z, TASK_DEFINE_Q_INV_Z, int16_t, raw.q_inv_z);
    PACK(fits, message->blend_s, TASK_DEFINE_BLEND_S, uint16_t, raw.blend_s);
    begin(frame, FRAME_TASK_DEFINE);
    (void)comanip_task_define_pack(frame->data, &raw, frame->length);
    return status_of(fits);
}

void task_define_unpack(const can_frame_t *frame, task_define_t *message) {
    struct comanip_task_define_t raw;
    (void)comanip_task_define_unpack(&raw, frame->data, frame->length);
    *message = (task_define_t){
        .sequence = raw.sequence,
        .form = raw.form,
        .t_task_m = {UNPACK(TASK_DEFINE_T_TASK_X_M, raw.t_task_x_m), UNPACK(TASK_DEFINE_T_TASK_Y_M, raw.t_task_y_m),
                     UNPACK(TASK_DEFINE_T_TASK_Z_M, raw.t_task_z_m)},
        .q_task = {UNPACK(TASK_DEFINE_Q_TASK_W, raw.q_task_w), UNPACK(TASK_DEFINE_Q_TASK_X, raw.q_task_x),
                   UNPACK(TASK_DEFINE_Q_TASK_Y, raw.q_task_y), UNPACK(TASK_DEFINE_Q_TASK_Z, raw.q_task_z)},
        .q_inv = {UNPACK(TASK_DEFINE_Q_INV_W, raw.q_inv_w), UNPACK(TASK_DEFINE_Q_INV_X, raw.q_inv_x),
                  UNPACK(TASK_DEFINE_Q_INV_Y, raw.q_inv_y), UNPACK(TASK_DEFINE_Q_INV_Z, raw.q_inv_z)},
        .blend_s = UNPACK(TASK_DEFINE_BLEND_S, raw.blend_s),
    };
}

protocol_status_t parameter_access_pack(const parameter_access_t *message, can_frame_t *frame) {
    struct comanip_parameter_access_t raw = {
        .operation = message->operation,
        .parameter = message->parameter,
        .sequence = message->sequence,
        .value = message->value,
    };
    begin(frame, FRAME_PARAMETER_ACCESS);
    (void)comanip_parameter_access_pack(frame->data, &raw, frame->length);
    return PROTOCOL_OK;
}

void parameter_access_unpack(const can_frame_t *frame, parameter_access_t *message) {
    struct comanip_parameter_access_t raw;
    (void)comanip_parameter_access_unpack(&raw, frame->data, frame->length);
    *message = (parameter_access_t){
        .operation = raw.operation, .parameter = raw.parameter, .sequence = raw.sequence, .value = raw.value};
}

protocol_status_t firmware_status_pack(const firmware_status_t *message, can_frame_t *frame) {
    struct comanip_firmware_status_t raw = {
        .mode = (uint8_t)message->mode,
        .stop_category = (uint8_t)message->stop_category,
        .latched = message->latched,
        .rest_not_assured = message->rest_not_assured,
        .changes_posture = message->changes_posture,
        .reason = (uint8_t)message->reason,
        .task = (uint8_t)message->task,
        .rejected_frames = message->rejected_frames,
    };
    bool fits = true;
    PACK(fits, message->speed_limit_percent, FIRMWARE_STATUS_SPEED_LIMIT_PERCENT, uint8_t, raw.speed_limit_percent);
    begin(frame, FRAME_FIRMWARE_STATUS);
    (void)comanip_firmware_status_pack(frame->data, &raw, frame->length);
    return status_of(fits);
}

void firmware_status_unpack(const can_frame_t *frame, firmware_status_t *message) {
    struct comanip_firmware_status_t raw;
    (void)comanip_firmware_status_unpack(&raw, frame->data, frame->length);
    *message = (firmware_status_t){
        .mode = (control_mode_t)raw.mode,
        .reason = (reason_t)raw.reason,
        .stop_category = (stop_category_t)raw.stop_category,
        .task = (task_id_t)raw.task,
        .latched = raw.latched != 0u,
        .rest_not_assured = raw.rest_not_assured != 0u,
        .changes_posture = raw.changes_posture != 0u,
        .speed_limit_percent = UNPACK(FIRMWARE_STATUS_SPEED_LIMIT_PERCENT, raw.speed_limit_percent),
        .rejected_frames = raw.rejected_frames,
    };
}

protocol_status_t command_ack_pack(const command_ack_t *message, can_frame_t *frame) {
    struct comanip_command_ack_t raw = {
        .command = message->command, .sequence = message->sequence, .result = (uint8_t)message->result};
    begin(frame, FRAME_COMMAND_ACK);
    (void)comanip_command_ack_pack(frame->data, &raw, frame->length);
    return PROTOCOL_OK;
}

void command_ack_unpack(const can_frame_t *frame, command_ack_t *message) {
    struct comanip_command_ack_t raw;
    (void)comanip_command_ack_unpack(&raw, frame->data, frame->length);
    *message = (command_ack_t){.command = raw.command, .sequence = raw.sequence, .result = (result_t)raw.result};
}

protocol_status_t parameter_value_pack(const parameter_value_t *message, can_frame_t *frame) {
    struct comanip_parameter_value_t raw = {
        .parameter = message->parameter,
        .sequence = message->sequence,
        .result = (uint8_t)message->result,
        .value = message->value,
    };
    begin(frame, FRAME_PARAMETER_VALUE);
    (void)comanip_parameter_value_pack(frame->data, &raw, frame->length);
    return PROTOCOL_OK;
}

void parameter_value_unpack(const can_frame_t *frame, parameter_value_t *message) {
    struct comanip_parameter_value_t raw;
    (void)comanip_parameter_value_unpack(&raw, frame->data, frame->length);
    *message = (parameter_value_t){
        .parameter = raw.parameter, .sequence = raw.sequence, .result = (result_t)raw.result, .value = raw.value};
}

protocol_status_t firmware_identity_pack(const firmware_identity_t *message, can_frame_t *frame) {
    struct comanip_firmware_identity_t raw = {
        .build_hash = message->build_hash,
        .arm = message->arm,
        .joint_count = message->joint_count,
        .parameter_count = message->parameter_count,
    };
    begin(frame, FRAME_FIRMWARE_IDENTITY);
    (void)comanip_firmware_identity_pack(frame->data, &raw, frame->length);
    return PROTOCOL_OK;
}

void firmware_identity_unpack(const can_frame_t *frame, firmware_identity_t *message) {
    struct comanip_firmware_identity_t raw;
    (void)comanip_firmware_identity_unpack(&raw, frame->data, frame->length);
    *message = (firmware_identity_t){.build_hash = raw.build_hash,
                                     .arm = raw.arm,
                                     .joint_count = raw.joint_count,
                                     .parameter_count = raw.parameter_count};
}

/* Received kinds and their counters in TickTrace; TickTrace.received has a bit for each, in this order. */
#define FOR_EACH_RECEIVED(X)                                                                                           \
    X(FRAME_HAND_POSE, hand_pose)                                                                                      \
    X(FRAME_TRACKER_STATUS, tracker_status)                                                                            \
    X(FRAME_JOINT_STATE0, joint_state_0)                                                                               \
    X(FRAME_JOINT_STATE1, joint_state_1)                                                                               \
    X(FRAME_JOINT_STATE2, joint_state_2)                                                                               \
    X(FRAME_JOINT_STATE3, joint_state_3)                                                                               \
    X(FRAME_JOINT_STATE4, joint_state_4)                                                                               \
    X(FRAME_JOINT_STATE5, joint_state_5)                                                                               \
    X(FRAME_JOINT_STATE6, joint_state_6)                                                                               \
    X(FRAME_JOINT_STATE7, joint_state_7)                                                                               \
    X(FRAME_OPERATOR_COMMAND, operator_command)                                                                        \
    X(FRAME_TASK_DEFINE, task_define)                                                                                  \
    X(FRAME_PARAMETER_ACCESS, parameter_access)

#define HAND_AGE_MAX_US 0xFFFFFFu

protocol_status_t tick_trace_pack(const tick_trace_t *message, can_frame_t *frame) {
    struct comanip_tick_trace_t raw; /* all of it is set below, as in joint_command_pack() */
    raw.e2e_crc = 0;
    raw.e2e_counter = 0;
    raw.now_us = message->now_us;
    raw.drives_fresh = message->drives_fresh;
    raw.rejected_frames = message->rejected_frames;
    raw.hand_age_us = message->hand_age_us < HAND_AGE_MAX_US ? message->hand_age_us : HAND_AGE_MAX_US;
    raw.received = 0;
    uint16_t bit = 1;
#define PACK_COUNTER(kind, signal)                                                                                     \
    raw.signal##_counter = message->last[kind].counter;                                                                \
    raw.received = (uint16_t)(raw.received | (message->last[kind].started ? bit : 0u));                                \
    bit = (uint16_t)(bit << 1);
    FOR_EACH_RECEIVED(PACK_COUNTER)
    /* A target beyond what the frame carries is said to be none; the trace goes out. */
    bool fits = message->target_valid;
    const pose_t none = {{0.0f, 0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}}, *target = fits ? &message->target : &none;
    PACK(fits, target->translation_m.x, TICK_TRACE_TARGET_X_M, int32_t, raw.target_x_m);
    PACK(fits, target->translation_m.y, TICK_TRACE_TARGET_Y_M, int32_t, raw.target_y_m);
    PACK(fits, target->translation_m.z, TICK_TRACE_TARGET_Z_M, int32_t, raw.target_z_m);
    PACK(fits, target->rotation.w, TICK_TRACE_TARGET_QW, int16_t, raw.target_qw);
    PACK(fits, target->rotation.x, TICK_TRACE_TARGET_QX, int16_t, raw.target_qx);
    PACK(fits, target->rotation.y, TICK_TRACE_TARGET_QY, int16_t, raw.target_qy);
    PACK(fits, target->rotation.z, TICK_TRACE_TARGET_QZ, int16_t, raw.target_qz);
    raw.target_valid = fits;
    begin(frame, FRAME_TICK_TRACE);
    (void)comanip_tick_trace_pack(frame->data, &raw, frame->length);
    return PROTOCOL_OK;
}

void tick_trace_unpack(const can_frame_t *frame, tick_trace_t *message) {
    struct comanip_tick_trace_t raw;
    (void)comanip_tick_trace_unpack(&raw, frame->data, frame->length);
    quaternion_t r = {UNPACK(TICK_TRACE_TARGET_QW, raw.target_qw), UNPACK(TICK_TRACE_TARGET_QX, raw.target_qx),
                      UNPACK(TICK_TRACE_TARGET_QY, raw.target_qy), UNPACK(TICK_TRACE_TARGET_QZ, raw.target_qz)};
    vector3_t t = {UNPACK(TICK_TRACE_TARGET_X_M, raw.target_x_m), UNPACK(TICK_TRACE_TARGET_Y_M, raw.target_y_m),
                   UNPACK(TICK_TRACE_TARGET_Z_M, raw.target_z_m)};
    *message = (tick_trace_t){
        .now_us = raw.now_us,
        .target_valid = raw.target_valid != 0u,
        .target = {quaternion_normalise(r), t},
        .hand_age_us = raw.hand_age_us,
        .drives_fresh = raw.drives_fresh != 0u,
        .rejected_frames = raw.rejected_frames,
    };
    uint16_t bit = 1;
#define UNPACK_COUNTER(kind, signal)                                                                                   \
    message->last[kind].counter = raw.signal##_counter;                                                                \
    message->last[kind].started = (raw.received & bit) != 0u;                                                          \
    bit = (uint16_t)(bit << 1);
    FOR_EACH_RECEIVED(UNPACK_COUNTER)
}

protocol_status_t firmware_heartbeat_pack(heartbeat_state_t state, can_frame_t *frame) {
    struct comanip_firmware_heartbeat_t raw = {.state = (uint8_t)state};
    begin(frame, FRAME_FIRMWARE_HEARTBEAT);
    (void)comanip_firmware_heartbeat_pack(frame->data, &raw, frame->length);
    return PROTOCOL_OK;
}

protocol_status_t gripper_command_pack(const gripper_command_t *message, can_frame_t *frame) {
    struct comanip_gripper_command_t raw = {.action = message->action, .sequence = message->sequence};
    begin(frame, FRAME_GRIPPER_COMMAND);
    (void)comanip_gripper_command_pack(frame->data, &raw, frame->length);
    return PROTOCOL_OK;
}

void gripper_command_unpack(const can_frame_t *frame, gripper_command_t *message) {
    struct comanip_gripper_command_t raw;
    (void)comanip_gripper_command_unpack(&raw, frame->data, frame->length);
    *message = (gripper_command_t){.action = raw.action, .sequence = raw.sequence};
}

protocol_status_t gripper_state_pack(const gripper_state_t *message, can_frame_t *frame) {
    struct comanip_gripper_state_t raw = {.sequence = message->sequence, .state = (uint8_t)message->state};
    bool fits = true;
    PACK(fits, message->opening_percent, GRIPPER_STATE_OPENING_PERCENT, uint8_t, raw.opening_percent);
    PACK(fits, message->force_N, GRIPPER_STATE_FORCE_N, uint16_t, raw.force_n);
    begin(frame, FRAME_GRIPPER_STATE);
    (void)comanip_gripper_state_pack(frame->data, &raw, frame->length);
    return status_of(fits);
}

void gripper_state_unpack(const can_frame_t *frame, gripper_state_t *message) {
    struct comanip_gripper_state_t raw;
    (void)comanip_gripper_state_unpack(&raw, frame->data, frame->length);
    *message = (gripper_state_t){
        .sequence = raw.sequence,
        .state = (gripper_status_t)raw.state,
        .opening_percent = UNPACK(GRIPPER_STATE_OPENING_PERCENT, raw.opening_percent),
        .force_N = UNPACK(GRIPPER_STATE_FORCE_N, raw.force_n),
    };
}

protocol_status_t clearance_report_pack(const clearance_report_t *message, can_frame_t *frame) {
    struct comanip_clearance_t raw = {
        .person_valid = message->person_valid,
        .self_valid = message->self_valid,
        .person = message->person,
        .person_part = message->person_part,
        .robot_part = message->robot_part,
        .arm_part = message->arm_part,
        .body_part = message->body_part,
    };
    bool fits = true;
    PACK(fits, message->person_m, CLEARANCE_PERSON_M, uint16_t, raw.person_m);
    PACK(fits, message->self_m, CLEARANCE_SELF_M, uint16_t, raw.self_m);
    begin(frame, FRAME_CLEARANCE);
    (void)comanip_clearance_pack(frame->data, &raw, frame->length);
    return status_of(fits);
}

void clearance_report_unpack(const can_frame_t *frame, clearance_report_t *message) {
    struct comanip_clearance_t raw;
    (void)comanip_clearance_unpack(&raw, frame->data, frame->length);
    *message = (clearance_report_t){
        .person_m = UNPACK(CLEARANCE_PERSON_M, raw.person_m),
        .self_m = UNPACK(CLEARANCE_SELF_M, raw.self_m),
        .person_valid = raw.person_valid != 0u,
        .self_valid = raw.self_valid != 0u,
        .person = raw.person,
        .person_part = raw.person_part,
        .robot_part = raw.robot_part,
        .arm_part = raw.arm_part,
        .body_part = raw.body_part,
    };
}
