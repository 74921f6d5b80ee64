#include "can_classic.h"

#include <string.h>

#include "comanip_dbc.h"
#include "rotation_code.h"

#define FRAME_ROW(name, id, bytes, data_id, period_ms, timeout_ms, to_firmware)                                        \
    {id, bytes, data_id, period_ms, timeout_ms, to_firmware},
const frame_description_t classic_table[CLASSIC_FRAME_COUNT] = {COMANIP_CLASSIC_FRAMES(FRAME_ROW)};

_Static_assert(CLASSIC_MAX_PARTS == ARM_MAX_JOINTS, "a part of JointCmd for each joint");

typedef uint8_t message_t[CAN_FRAME_MAX_BYTES];
typedef uint8_t part_t[CLASSIC_MAX_BYTES];

/* `raw` is a message's or a part's struct of the generated code. */
#define FROM_MESSAGE(name, raw)                                                                                        \
    struct comanip_##name##_t raw;                                                                                     \
    (void)comanip_##name##_unpack(&raw, message, sizeof(message_t))
#define FROM_PART(name, raw, i)                                                                                        \
    struct comanip_classic_##name##_t raw;                                                                             \
    (void)comanip_classic_##name##_unpack(&raw, part[i], sizeof(part_t))
#define TO_MESSAGE(name, raw) (void)comanip_##name##_pack(message, &(raw), sizeof(message_t))
#define TO_PART(name, raw, i) (void)comanip_classic_##name##_pack(part[i], &(raw), sizeof(part_t))

/* ---- what is coarser */

#define POSITION_STEP 100 /* of 1 um: 0.1 mm */
#define TORQUE_STEP 20    /* of 0.01 Nm: 0.2 Nm */

static int32_t divide_rounding(int32_t value, int32_t step) {
    return (value + (value < 0 ? -step : step) / 2) / step;
}

/* False, and *coarse is 0: beyond what the signal carries. */
static bool coarsen(int32_t fine, int32_t step, int32_t maximum, int32_t *coarse) {
    int32_t rounded = divide_rounding(fine, step);
    bool fits = rounded >= -maximum && rounded <= maximum;
    *coarse = fits ? rounded : 0;
    return fits;
}

static bool coarsen_position(const int32_t fine[3], int16_t *x, int16_t *y, int16_t *z) {
    int32_t coarse[3];
    bool fits = true;
    for (int i = 0; i < 3; i++) {
        fits = coarsen(fine[i], POSITION_STEP, INT16_MAX, &coarse[i]) && fits;
    }
    *x = (int16_t)(fits ? coarse[0] : 0);
    *y = (int16_t)(fits ? coarse[1] : 0);
    *z = (int16_t)(fits ? coarse[2] : 0);
    return fits;
}

/* ---- rotations */

/* TickTrace and TaskDefine carry quaternions in 16 bits. */
#define SHORT_ONE_BITS 14
#define SHORT_STEP ((int32_t)1 << (ROTATION_CODE_ONE_BITS - SHORT_ONE_BITS))

static bool encode_short_rotation(int16_t w, int16_t x, int16_t y, int16_t z, rotation_code_t *code) {
    const int32_t quaternion[4] = {w * SHORT_STEP, x * SHORT_STEP, y * SHORT_STEP, z * SHORT_STEP};
    return rotation_encode(quaternion, code);
}

static void decode_short_rotation(const rotation_code_t *code, int16_t *w, int16_t *x, int16_t *y, int16_t *z) {
    int32_t quaternion[4];
    rotation_decode(code, quaternion);
    *w = (int16_t)divide_rounding(quaternion[0], SHORT_STEP);
    *x = (int16_t)divide_rounding(quaternion[1], SHORT_STEP);
    *y = (int16_t)divide_rounding(quaternion[2], SHORT_STEP);
    *z = (int16_t)divide_rounding(quaternion[3], SHORT_STEP);
}

#define PUT_ROTATION(code, raw, prefix)                                                                                \
    do {                                                                                                               \
        (raw).prefix##_a = (code).smaller[0];                                                                          \
        (raw).prefix##_b = (code).smaller[1];                                                                          \
        (raw).prefix##_c = (code).smaller[2];                                                                          \
        (raw).prefix##_largest = (code).largest;                                                                       \
    } while (0)
#define GET_ROTATION(raw, prefix)                                                                                      \
    {.smaller = {(raw).prefix##_a, (raw).prefix##_b, (raw).prefix##_c}, .largest = (raw).prefix##_largest}

/* ---- messages of one frame with the same signals */

#define COPY(signal) to.signal = from.signal;
#define SAME_SIGNALS(name, SIGNALS, fits)                                                                              \
    static bool split_##name(const message_t message, part_t part[]) {                                                 \
        FROM_MESSAGE(name, from);                                                                                      \
        struct comanip_classic_##name##_t to = {0};                                                                    \
        SIGNALS(COPY)                                                                                                  \
        TO_PART(name, to, 0);                                                                                          \
        return fits;                                                                                                   \
    }                                                                                                                  \
    static void join_##name(part_t part[], message_t message) {                                                        \
        FROM_PART(name, from, 0);                                                                                      \
        struct comanip_##name##_t to = {0};                                                                            \
        SIGNALS(COPY)                                                                                                  \
        TO_MESSAGE(name, to);                                                                                          \
    }

#define OPERATION_MAX 15u

/* clang-format off */
#define FIRMWARE_STATUS_SIGNALS(X)                                                                                     \
    X(mode) X(latched) X(stop_category) X(rest_not_assured) X(changes_posture) X(reason) X(task)                       \
    X(speed_limit_percent) X(rejected_frames)
/* clang-format on */
#define COMMAND_ACK_SIGNALS(X) X(result) X(command) X(sequence)
#define PARAMETER_VALUE_SIGNALS(X) X(result) X(parameter) X(sequence) X(value)
#define OPERATOR_COMMAND_SIGNALS(X) X(command) X(sequence) X(task)
#define PARAMETER_ACCESS_SIGNALS(X) X(operation) X(parameter) X(sequence) X(value)
#define GRIPPER_COMMAND_SIGNALS(X) X(action) X(sequence)
#define GRIPPER_STATE_SIGNALS(X) X(state) X(sequence) X(opening_percent) X(force_n)
#define CLEARANCE_SIGNALS(X)                                                                                           \
    X(person_m) X(self_m) X(person_valid) X(self_valid) X(person) X(person_part) X(robot_part) X(arm_part) X(body_part)

SAME_SIGNALS(firmware_status, FIRMWARE_STATUS_SIGNALS, true)
SAME_SIGNALS(command_ack, COMMAND_ACK_SIGNALS, true)
SAME_SIGNALS(parameter_value, PARAMETER_VALUE_SIGNALS, true)
SAME_SIGNALS(operator_command, OPERATOR_COMMAND_SIGNALS, true)
SAME_SIGNALS(parameter_access, PARAMETER_ACCESS_SIGNALS, from.operation <= OPERATION_MAX)
SAME_SIGNALS(gripper_command, GRIPPER_COMMAND_SIGNALS, true)
SAME_SIGNALS(gripper_state, GRIPPER_STATE_SIGNALS, true)
SAME_SIGNALS(clearance, CLEARANCE_SIGNALS, true)

/* ---- tracker */

#define STAMP_LOW(t_us) (uint8_t)(((t_us) / CLASSIC_STAMP_STEP_US) & 0xFu)
#define STAMP_HIGH(t_us) (uint8_t)(((t_us) / CLASSIC_STAMP_STEP_US >> 4) & 0xFu)

static bool split_hand_pose(const message_t message, part_t part[]) {
    FROM_MESSAGE(hand_pose, from);
    struct comanip_classic_hand_position_t position = {.t_low = STAMP_LOW(from.t_us)};
    struct comanip_classic_hand_rotation_t rotation = {.t_high = STAMP_HIGH(from.t_us)};
    rotation_code_t code = {0};
    if (from.valid != 0u) {
        const int32_t fine[3] = {from.x_m, from.y_m, from.z_m}, quaternion[4] = {from.qw, from.qx, from.qy, from.qz};
        rotation.valid =
            coarsen_position(fine, &position.x_m, &position.y_m, &position.z_m) && rotation_encode(quaternion, &code);
    }
    PUT_ROTATION(code, rotation, q);
    TO_PART(hand_position, position, 0);
    TO_PART(hand_rotation, rotation, 1);
    return true;
}

static void join_hand_pose(part_t part[], message_t message) {
    FROM_PART(hand_position, position, 0);
    FROM_PART(hand_rotation, rotation, 1);
    const rotation_code_t code = GET_ROTATION(rotation, q);
    int32_t quaternion[4];
    rotation_decode(&code, quaternion);
    struct comanip_hand_pose_t to = {
        .t_us = CLASSIC_STAMP_STEP_US * ((uint32_t)rotation.t_high << 4 | position.t_low),
        .x_m = POSITION_STEP * position.x_m,
        .y_m = POSITION_STEP * position.y_m,
        .z_m = POSITION_STEP * position.z_m,
        .qw = quaternion[0],
        .qx = quaternion[1],
        .qy = quaternion[2],
        .qz = quaternion[3],
        .valid = rotation.valid,
    };
    TO_MESSAGE(hand_pose, to);
}

uint32_t classic_unwrap_stamp(message_t message, uint32_t expected_us) {
    FROM_MESSAGE(hand_pose, raw);
    uint32_t ahead_us = (raw.t_us - expected_us) % CLASSIC_STAMP_PERIOD_US;
    raw.t_us = expected_us + ahead_us - (ahead_us >= CLASSIC_STAMP_PERIOD_US / 2u ? CLASSIC_STAMP_PERIOD_US : 0u);
    TO_MESSAGE(hand_pose, raw);
    return raw.t_us;
}

#define FAULT_MAX 15u

static bool split_tracker_status(const message_t message, part_t part[]) {
    FROM_MESSAGE(tracker_status, from);
    struct comanip_classic_tracker_clock_t clock = {
        .fault = from.fault, .t_us = from.t_us, .period_us = from.period_us};
    struct comanip_classic_tracker_status_t status = {
        .latency_us = from.latency_us, .lost_samples = from.lost_samples, .range_errors = from.range_errors};
    TO_PART(tracker_clock, clock, 0);
    TO_PART(tracker_status, status, 1);
    return from.fault <= FAULT_MAX;
}

static void join_tracker_status(part_t part[], message_t message) {
    FROM_PART(tracker_clock, clock, 0);
    FROM_PART(tracker_status, status, 1);
    struct comanip_tracker_status_t to = {
        .t_us = clock.t_us,
        .period_us = clock.period_us,
        .latency_us = status.latency_us,
        .fault = clock.fault,
        .lost_samples = status.lost_samples,
        .range_errors = status.range_errors,
    };
    TO_MESSAGE(tracker_status, to);
}

/* ---- drives */

/* ClassicJointCmd0 and ClassicJointState0 stand for all eight: the code generator checks that their layouts are one. */
static bool split_joint_command(int32_t position, int16_t velocity, int16_t torque, uint8_t mode, part_t part) {
    int32_t coarse_torque;
    bool fits = coarsen(torque, TORQUE_STEP, INT8_MAX, &coarse_torque);
    struct comanip_classic_joint_cmd0_t to = {
        .mode = mode, .position_rad = position, .velocity_radps = velocity, .torque_nm = (int8_t)coarse_torque};
    (void)comanip_classic_joint_cmd0_pack(part, &to, sizeof(part_t));
    return fits;
}

#define FOR_EACH_JOINT(X) X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7)

static bool split_joint_commands(const message_t message, part_t part[]) {
    FROM_MESSAGE(joint_cmd, from);
    bool fits = true;
#define SPLIT_JOINT(i)                                                                                                 \
    fits = split_joint_command(from.position_##i##_rad, from.velocity_##i##_radps, from.torque_##i##_nm,               \
                               from.mode_##i, part[i]) &&                                                              \
           fits;
    FOR_EACH_JOINT(SPLIT_JOINT)
    return fits;
}

static void join_joint_commands(part_t part[], message_t message) {
    struct comanip_joint_cmd_t to = {0};
#define JOIN_JOINT(i)                                                                                                  \
    {                                                                                                                  \
        FROM_PART(joint_cmd0, from, i);                                                                                \
        to.mode_##i = from.mode;                                                                                       \
        to.position_##i##_rad = from.position_rad;                                                                     \
        to.velocity_##i##_radps = from.velocity_radps;                                                                 \
        to.torque_##i##_nm = (int16_t)(TORQUE_STEP * from.torque_nm);                                                  \
    }
    FOR_EACH_JOINT(JOIN_JOINT)
    TO_MESSAGE(joint_cmd, to);
}

#define MODE_MAX 1u
#define ERROR_MAX 7u

static bool split_joint_state(const message_t message, part_t part[]) {
    FROM_MESSAGE(joint_state0, from);
    int32_t torque;
    bool fits = coarsen(from.torque_nm, TORQUE_STEP, INT8_MAX, &torque);
    struct comanip_classic_joint_state0_t to = {
        .mode = from.mode,
        .error = from.error,
        .position_rad = from.position_rad,
        .velocity_radps = from.velocity_radps,
        .torque_nm = (int8_t)torque,
    };
    TO_PART(joint_state0, to, 0);
    return fits && from.mode <= MODE_MAX && from.error <= ERROR_MAX;
}

static void join_joint_state(part_t part[], message_t message) {
    FROM_PART(joint_state0, from, 0);
    struct comanip_joint_state0_t to = {
        .position_rad = from.position_rad,
        .velocity_radps = from.velocity_radps,
        .torque_nm = (int16_t)(TORQUE_STEP * from.torque_nm),
        .mode = from.mode,
        .error = from.error,
    };
    TO_MESSAGE(joint_state0, to);
}

/* ---- operator */

#define FORM_MAX 15u

static bool split_task_define(const message_t message, part_t part[]) {
    FROM_MESSAGE(task_define, from);
    struct comanip_classic_task_define_t define = {
        .form = from.form, .sequence = from.sequence, .blend_s = from.blend_s};
    struct comanip_classic_task_translation_t translation;
    struct comanip_classic_task_rotation_t rotation = {0};
    struct comanip_classic_task_inverse_t inverse = {0};
    const int32_t fine[3] = {from.t_task_x_m, from.t_task_y_m, from.t_task_z_m};
    rotation_code_t q_task, q_inv;
    bool fits = coarsen_position(fine, &translation.t_task_x_m, &translation.t_task_y_m, &translation.t_task_z_m);
    fits = encode_short_rotation(from.q_task_w, from.q_task_x, from.q_task_y, from.q_task_z, &q_task) && fits;
    fits = encode_short_rotation(from.q_inv_w, from.q_inv_x, from.q_inv_y, from.q_inv_z, &q_inv) && fits;
    PUT_ROTATION(q_task, rotation, q_task);
    PUT_ROTATION(q_inv, inverse, q_inv);
    TO_PART(task_define, define, 0);
    TO_PART(task_translation, translation, 1);
    TO_PART(task_rotation, rotation, 2);
    TO_PART(task_inverse, inverse, 3);
    return fits && from.form <= FORM_MAX;
}

static void join_task_define(part_t part[], message_t message) {
    FROM_PART(task_define, define, 0);
    FROM_PART(task_translation, translation, 1);
    FROM_PART(task_rotation, rotation, 2);
    FROM_PART(task_inverse, inverse, 3);
    const rotation_code_t q_task = GET_ROTATION(rotation, q_task), q_inv = GET_ROTATION(inverse, q_inv);
    struct comanip_task_define_t to = {
        .sequence = define.sequence,
        .form = define.form,
        .t_task_x_m = POSITION_STEP * translation.t_task_x_m,
        .t_task_y_m = POSITION_STEP * translation.t_task_y_m,
        .t_task_z_m = POSITION_STEP * translation.t_task_z_m,
        .blend_s = define.blend_s,
    };
    decode_short_rotation(&q_task, &to.q_task_w, &to.q_task_x, &to.q_task_y, &to.q_task_z);
    decode_short_rotation(&q_inv, &to.q_inv_w, &to.q_inv_x, &to.q_inv_y, &to.q_inv_z);
    TO_MESSAGE(task_define, to);
}

/* ---- firmware */

#define BUILD_HASH_LOW_BITS 48
#define BUILD_HASH_LOW_MASK (((uint64_t)1 << BUILD_HASH_LOW_BITS) - 1u)

static bool split_firmware_identity(const message_t message, part_t part[]) {
    FROM_MESSAGE(firmware_identity, from);
    struct comanip_classic_firmware_build_t build = {.build_hash_low = from.build_hash & BUILD_HASH_LOW_MASK};
    struct comanip_classic_firmware_identity_t identity = {
        .build_hash_high = (uint16_t)(from.build_hash >> BUILD_HASH_LOW_BITS),
        .arm = from.arm,
        .joint_count = from.joint_count,
        .parameter_count = from.parameter_count,
    };
    TO_PART(firmware_build, build, 0);
    TO_PART(firmware_identity, identity, 1);
    return true;
}

static void join_firmware_identity(part_t part[], message_t message) {
    FROM_PART(firmware_build, build, 0);
    FROM_PART(firmware_identity, identity, 1);
    struct comanip_firmware_identity_t to = {
        .build_hash = (uint64_t)identity.build_hash_high << BUILD_HASH_LOW_BITS | build.build_hash_low,
        .arm = identity.arm,
        .joint_count = identity.joint_count,
        .parameter_count = identity.parameter_count,
    };
    TO_MESSAGE(firmware_identity, to);
}

/* Received kinds by the names of their counters, which have four bits in either frame of this profile. */
/* clang-format off */
#define FOR_EACH_COUNTER(X)                                                                                            \
    X(joint_state_0) X(joint_state_1) X(joint_state_2) X(joint_state_3) X(joint_state_4) X(joint_state_5)              \
    X(joint_state_6) X(joint_state_7) X(operator_command) X(task_define) X(parameter_access)
/* clang-format on */

static bool split_tick_trace(const message_t message, part_t part[]) {
    FROM_MESSAGE(tick_trace, from);
    struct comanip_classic_tick_trace_t trace = {
        .drives_fresh = from.drives_fresh,
        .now_us = from.now_us,
        .hand_pose_counter = from.hand_pose_counter,
        .tracker_status_counter = from.tracker_status_counter,
        .rejected_frames = from.rejected_frames,
    };
    struct comanip_classic_tick_trace_inputs_t inputs;
#define SPLIT_COUNTER(name) inputs.name##_counter = from.name##_counter;
    FOR_EACH_COUNTER(SPLIT_COUNTER)
    struct comanip_classic_tick_trace_age_t age = {.hand_age_us = from.hand_age_us, .received = from.received};
    struct comanip_classic_target_position_t position = {0};
    struct comanip_classic_target_rotation_t rotation = {0};
    rotation_code_t code = {0};
    if (from.target_valid != 0u) {
        const int32_t fine[3] = {from.target_x_m, from.target_y_m, from.target_z_m};
        trace.target_valid =
            coarsen_position(fine, &position.target_x_m, &position.target_y_m, &position.target_z_m) &&
            encode_short_rotation(from.target_qw, from.target_qx, from.target_qy, from.target_qz, &code);
    }
    PUT_ROTATION(code, rotation, target);
    TO_PART(tick_trace, trace, 0);
    TO_PART(tick_trace_inputs, inputs, 1);
    TO_PART(tick_trace_age, age, 2);
    TO_PART(target_position, position, 3);
    TO_PART(target_rotation, rotation, 4);
    return true;
}

static void join_tick_trace(part_t part[], message_t message) {
    FROM_PART(tick_trace, trace, 0);
    FROM_PART(tick_trace_inputs, inputs, 1);
    FROM_PART(tick_trace_age, age, 2);
    FROM_PART(target_position, position, 3);
    FROM_PART(target_rotation, rotation, 4);
    struct comanip_tick_trace_t to = {
        .now_us = trace.now_us,
        .hand_pose_counter = trace.hand_pose_counter,
        .tracker_status_counter = trace.tracker_status_counter,
        .target_x_m = POSITION_STEP * position.target_x_m,
        .target_y_m = POSITION_STEP * position.target_y_m,
        .target_z_m = POSITION_STEP * position.target_z_m,
        .target_valid = trace.target_valid,
        .drives_fresh = trace.drives_fresh,
        .received = age.received,
        .hand_age_us = age.hand_age_us,
        .rejected_frames = trace.rejected_frames,
    };
#define JOIN_COUNTER(name) to.name##_counter = inputs.name##_counter;
    FOR_EACH_COUNTER(JOIN_COUNTER)
    const rotation_code_t code = GET_ROTATION(rotation, target);
    decode_short_rotation(&code, &to.target_qw, &to.target_qx, &to.target_qy, &to.target_qz);
    TO_MESSAGE(tick_trace, to);
}

/* ---- which message is which frames */

typedef struct {
    classic_frame_t first;
    uint8_t parts;
    bool (*split)(const message_t message, part_t part[]);
    void (*join)(part_t part[], message_t message);
} codec_t;

#define JOINT_STATE_ROW(i) [FRAME_JOINT_STATE##i] = {CLASSIC_JOINT_STATE##i, 1, split_joint_state, join_joint_state},

static const codec_t codec_table[FRAME_KIND_COUNT] = {
    [FRAME_FIRMWARE_STATUS] = {CLASSIC_FIRMWARE_STATUS, 1, split_firmware_status, join_firmware_status},
    [FRAME_COMMAND_ACK] = {CLASSIC_COMMAND_ACK, 1, split_command_ack, join_command_ack},
    [FRAME_PARAMETER_VALUE] = {CLASSIC_PARAMETER_VALUE, 1, split_parameter_value, join_parameter_value},
    [FRAME_FIRMWARE_IDENTITY] = {CLASSIC_FIRMWARE_BUILD, 2, split_firmware_identity, join_firmware_identity},
    [FRAME_JOINT_CMD] = {CLASSIC_JOINT_CMD0, ARM_MAX_JOINTS, split_joint_commands, join_joint_commands},
    [FRAME_TICK_TRACE] = {CLASSIC_TICK_TRACE, 5, split_tick_trace, join_tick_trace},
    [FRAME_CLEARANCE] = {CLASSIC_CLEARANCE, 1, split_clearance, join_clearance},
    [FRAME_HAND_POSE] = {CLASSIC_HAND_POSITION, 2, split_hand_pose, join_hand_pose},
    FOR_EACH_JOINT(JOINT_STATE_ROW)[FRAME_GRIPPER_STATE] = {CLASSIC_GRIPPER_STATE, 1, split_gripper_state,
                                                            join_gripper_state},
    [FRAME_OPERATOR_COMMAND] = {CLASSIC_OPERATOR_COMMAND, 1, split_operator_command, join_operator_command},
    [FRAME_TASK_DEFINE] = {CLASSIC_TASK_DEFINE, 4, split_task_define, join_task_define},
    [FRAME_PARAMETER_ACCESS] = {CLASSIC_PARAMETER_ACCESS, 1, split_parameter_access, join_parameter_access},
    [FRAME_GRIPPER_COMMAND] = {CLASSIC_GRIPPER_COMMAND, 1, split_gripper_command, join_gripper_command},
    [FRAME_TRACKER_STATUS] = {CLASSIC_TRACKER_CLOCK, 2, split_tracker_status, join_tracker_status},
};

classic_frame_t classic_first(frame_kind_t kind) {
    return codec_table[kind].first;
}

uint8_t classic_parts(frame_kind_t kind, uint8_t joint_count) {
    return kind == FRAME_JOINT_CMD ? joint_count : codec_table[kind].parts;
}

bool classic_find(uint16_t id, classic_frame_t *frame, frame_kind_t *kind) {
    for (int k = 0; k < FRAME_KIND_COUNT; k++) {
        for (uint8_t i = 0; i < codec_table[k].parts; i++) {
            if (classic_table[codec_table[k].first + i].id == id) {
                *frame = (classic_frame_t)(codec_table[k].first + i);
                *kind = (frame_kind_t)k;
                return true;
            }
        }
    }
    return false;
}

bool classic_split(frame_kind_t kind, const message_t message, part_t part[CLASSIC_MAX_PARTS]) {
    return codec_table[kind].split(message, part);
}

void classic_join(frame_kind_t kind, part_t part[CLASSIC_MAX_PARTS], message_t message) {
    codec_table[kind].join(part, message);
}
