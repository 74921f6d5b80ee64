/* The CAN FD frames of comanip.dbc in SI units: scaling, rounding, range checks and end-to-end protection over the
 * generated packing of raw integers. Ids, layouts, scales and Data IDs stand in the DBC alone. can_transport.h is for
 * nodes, which may be on classic CAN as well:
 *
 *   sending:   X_pack(&message, &frame); transport_send(&sender, &frame, ...);
 *   receiving: if (transport_receive(&receiver, &frame, &kind) == PROTOCOL_OK) X_unpack(&frame, &message);
 *
 * pack sets id and length and rounds to nearest. A value that its signal cannot carry (or NaN) is never saturated:
 * pack returns PROTOCOL_OUT_OF_RANGE, and the frame is then not to be sent; a HandPose is then packed as invalid, to be
 * sent and counted. unpack expects a frame that protocol_check() accepted. */
#ifndef COMANIP_CAN_PROTOCOL_H
#define COMANIP_CAN_PROTOCOL_H

#include <stdbool.h>
#include <stdint.h>

#include "../arms/arm.h"
#include "../control/task.h"
#include "../maths/pose.h"
#include "can_frame.h"
#include "e2e.h"

/* FRAME_JOINT_STATE0 + i is joint i. */
typedef enum {
    FRAME_FIRMWARE_STATUS,
    FRAME_COMMAND_ACK,
    FRAME_PARAMETER_VALUE,
    FRAME_FIRMWARE_IDENTITY,
    FRAME_JOINT_CMD,
    FRAME_TICK_TRACE,
    FRAME_CLEARANCE,
    FRAME_HAND_POSE,
    FRAME_JOINT_STATE0,
    FRAME_JOINT_STATE1,
    FRAME_JOINT_STATE2,
    FRAME_JOINT_STATE3,
    FRAME_JOINT_STATE4,
    FRAME_JOINT_STATE5,
    FRAME_JOINT_STATE6,
    FRAME_JOINT_STATE7,
    FRAME_GRIPPER_STATE,
    FRAME_OPERATOR_COMMAND,
    FRAME_TASK_DEFINE,
    FRAME_PARAMETER_ACCESS,
    FRAME_GRIPPER_COMMAND,
    FRAME_TRACKER_STATUS,
    FRAME_FIRMWARE_HEARTBEAT,
    FRAME_KIND_COUNT
} frame_kind_t;

typedef enum {
    PROTOCOL_INCOMPLETE = 1, /* classic CAN: a part was taken, the message is not yet whole */
    PROTOCOL_OK = 0,
    PROTOCOL_UNKNOWN_ID = -1,
    PROTOCOL_WRONG_LENGTH = -2,
    PROTOCOL_NOT_AUTHENTIC = -3, /* CRC, repetition or sequence: see e2e.h */
    PROTOCOL_OUT_OF_RANGE = -4,
} protocol_status_t;

/* What the DBC says of a frame. */
typedef struct {
    uint16_t id;
    uint8_t length;
    uint16_t data_id;   /* 0: without end-to-end protection */
    uint16_t period_ms; /* 0: sent on events */
    uint16_t timeout_ms;
    bool to_firmware; /* the firmware receives it */
} frame_description_t;

extern const frame_description_t frame_table[FRAME_KIND_COUNT];

/* One per sender: the next counter of each frame. Zero-initialise. */
typedef struct {
    uint8_t counter[FRAME_KIND_COUNT];
} protocol_sender_t;

/* One per receiver. Zero-initialise. */
typedef struct {
    e2e_receiver_t e2e[FRAME_KIND_COUNT];
    uint32_t rejected; /* frames refused so far */
} protocol_receiver_t;

/* False: another system's frame on the same bus, none of our business; *kind then means nothing. */
bool protocol_find(uint16_t id, frame_kind_t *kind);

/* Frames of other systems stay as they are. */
void protocol_protect(protocol_sender_t *self, can_frame_t *frame);

/* Frames sent on events are accepted whatever number of them was lost, for a sender that was restarted must be heard;
 * only a repetition is refused. Every refusal is counted. */
protocol_status_t protocol_check(protocol_receiver_t *self, const can_frame_t *frame, frame_kind_t kind);

/* ---- tracker -> firmware */

typedef struct {
    uint32_t t_us; /* tracker's clock, wraps */
    vector3_t position_m;
    quaternion_t rotation;
    bool valid;
} hand_pose_t;

typedef struct {
    uint32_t t_us;
    uint32_t period_us;  /* resolution 10 us, up to 655,350 */
    uint32_t latency_us; /* from the measurement to the frame, as the tracker knows it */
    uint8_t fault;
    uint16_t lost_samples; /* sent as invalid since start, modulo 65,536 */
    uint16_t range_errors; /* of these, measurements that no frame can carry */
} tracker_status_t;

protocol_status_t hand_pose_pack(const hand_pose_t *message, can_frame_t *frame);
void hand_pose_unpack(const can_frame_t *frame, hand_pose_t *message);
protocol_status_t tracker_status_pack(const tracker_status_t *message, can_frame_t *frame);
void tracker_status_unpack(const can_frame_t *frame, tracker_status_t *message);

/* ---- drives <-> firmware */

typedef enum {
    DRIVE_MODE_BRAKE = 0,    /* holds its position without a command */
    DRIVE_MODE_VELOCITY = 1, /* servo on the commanded velocity */
} drive_mode_t;

typedef enum {
    DRIVE_ERROR_NONE = 0,
    DRIVE_ERROR_COMMAND_TIMEOUT = 1, /* no JointCmd for its timeout: the drive has stopped by itself */
    DRIVE_ERROR_OVER_TEMPERATURE = 2,
    DRIVE_ERROR_ENCODER = 3,
} drive_error_t;

typedef struct {
    drive_mode_t mode[ARM_MAX_JOINTS];
    float position_rad[ARM_MAX_JOINTS]; /* reference, for the drive's supervision */
    float velocity_radps[ARM_MAX_JOINTS];
    float torque_Nm[ARM_MAX_JOINTS]; /* feed-forward */
} joint_command_t;

typedef struct {
    float position_rad;
    float velocity_radps;
    float torque_Nm;
    drive_mode_t mode;
    drive_error_t error;
    int8_t temperature_degC;
} joint_state_t;

protocol_status_t joint_command_pack(const joint_command_t *message, can_frame_t *frame);
void joint_command_unpack(const can_frame_t *frame, joint_command_t *message);
protocol_status_t joint_state_pack(int joint, const joint_state_t *message, can_frame_t *frame);
void joint_state_unpack(const can_frame_t *frame, joint_state_t *message);

/* ---- operator -> firmware */

typedef enum {
    COMMAND_NONE = 0,
    COMMAND_SELECT = 1,
    COMMAND_START = 2,
    COMMAND_LATCH = 3,
    COMMAND_CLUTCH = 4,
    COMMAND_STOP = 5,
    COMMAND_DEFINE = 6, /* the name under which a TaskDefine is acknowledged */
} command_t;

typedef struct {
    uint8_t command;  /* command_t, or a number unknown to this firmware */
    uint8_t sequence; /* comes back in the acknowledgement */
    uint8_t task;     /* task_id_t; COMMAND_SELECT only */
} operator_command_t;

typedef struct {
    uint8_t sequence;
    uint8_t form; /* task_form_t */
    vector3_t t_task_m;
    quaternion_t q_task;
    quaternion_t q_inv;
    float blend_s; /* 0..65.535 */
} task_define_t;

typedef enum {
    PARAMETER_READ = 0,
    PARAMETER_WRITE = 1,
    PARAMETER_SAVE = 2, /* all parameters, for the next boot; `parameter` and `value` mean nothing */
} parameter_operation_t;

typedef struct {
    uint8_t operation; /* parameter_operation_t */
    uint8_t parameter;
    uint8_t sequence;
    float value;
} parameter_access_t;

protocol_status_t operator_command_pack(const operator_command_t *message, can_frame_t *frame);
void operator_command_unpack(const can_frame_t *frame, operator_command_t *message);
protocol_status_t task_define_pack(const task_define_t *message, can_frame_t *frame);
void task_define_unpack(const can_frame_t *frame, task_define_t *message);
protocol_status_t parameter_access_pack(const parameter_access_t *message, can_frame_t *frame);
void parameter_access_unpack(const can_frame_t *frame, parameter_access_t *message);

/* ---- firmware -> operator */

typedef enum {
    MODE_IDLE = 0,  /* drives or tracker are not there yet */
    MODE_READY = 1, /* all inputs are fresh; waits for the start command */
    MODE_COOPERATING = 2,
    MODE_HOLD = 3,  /* the tracker is stale: the arm stands; goes on by itself when poses return */
    MODE_FAULT = 4, /* latched: left by the stop command once the cause is gone */
} control_mode_t;

/* Why the mode is what it is. */
typedef enum {
    REASON_BOOT = 0,
    REASON_WAITING_FOR_DRIVES = 1,
    REASON_WAITING_FOR_TRACKER = 2,
    REASON_INPUTS_READY = 3,
    REASON_OPERATOR_START = 4,
    REASON_OPERATOR_STOP = 5,
    REASON_TRACKER_STALE = 6,
    REASON_TRACKER_RETURNED = 7,
    REASON_DRIVE_SILENT = 8,
    REASON_DRIVE_ERROR = 9,
    REASON_NOT_FINITE = 10,
    REASON_FAULT_CLEARED = 11,
} reason_t;

/* IEC 60204-1. 1: stop, then power off (here: brake). 2: stop under control, drives stay on. */
typedef enum {
    STOP_CATEGORY_NONE = 0,
    STOP_CATEGORY_1 = 1,
    STOP_CATEGORY_2 = 2,
} stop_category_t;

typedef enum {
    RESULT_ACCEPTED = 0,
    RESULT_WRONG_MODE = 1,
    RESULT_UNKNOWN_COMMAND = 2,
    RESULT_UNKNOWN_TASK = 3,
    RESULT_NOT_A_UNIT_QUATERNION = 4,
    RESULT_OUT_OF_RANGE = 5,
    RESULT_TRACKER_STALE = 6,
    RESULT_UNKNOWN_PARAMETER = 7,
    RESULT_FAULT_PRESENT = 8,
    RESULT_NOT_SUPPORTED = 9, /* by this port */
    RESULT_STORE_FAILED = 10, /* parameters could not be saved; at boot: what is stored is not valid, so defaults */
    RESULT_PARAMETERS_UNSTABLE = 11, /* together: see parameter_set.h */
} result_t;

typedef struct {
    control_mode_t mode;
    reason_t reason;
    stop_category_t stop_category;
    task_id_t task;
    bool latched;              /* q_task is latched (section V-B.3) */
    bool rest_not_assured;     /* the arm may go on moving while the hand rests: see parameter_set.h */
    bool changes_posture;      /* the arm is on its way to another posture, out of a dead end: see posture_change.h */
    float speed_limit_percent; /* of the arm's velocity limits */
    uint8_t rejected_frames;   /* modulo 256 */
} firmware_status_t;

typedef struct {
    uint8_t command;
    uint8_t sequence;
    result_t result;
} command_ack_t;

typedef struct {
    uint8_t parameter;
    uint8_t sequence; /* 0 for those published at boot; of what was refused, for those that were involved */
    result_t result;
    float value; /* in force */
} parameter_value_t;

typedef struct {
    uint64_t build_hash; /* of the firmware's sources and the DBC */
    uint8_t arm;
    uint8_t joint_count;
    uint8_t parameter_count;
} firmware_identity_t;

typedef struct {
    uint32_t now_us;
    e2e_receiver_t
        last[FRAME_KIND_COUNT]; /* of received kinds: the last frame whose CRC was right, if there has been one */
    bool target_valid;
    pose_t target;           /* robot hand in the torso frame */
    uint32_t hand_age_us;    /* limited to 24 bits */
    bool drives_fresh;       /* all drives had answered in time */
    uint8_t rejected_frames; /* modulo 256, this tick's included */
} tick_trace_t;

/* CANopen's NMT states. */
typedef enum {
    HEARTBEAT_BOOT_UP = 0,
    HEARTBEAT_STOPPED = 4,
    HEARTBEAT_OPERATIONAL = 5,
    HEARTBEAT_PRE_OPERATIONAL = 127,
} heartbeat_state_t;

protocol_status_t firmware_status_pack(const firmware_status_t *message, can_frame_t *frame);
void firmware_status_unpack(const can_frame_t *frame, firmware_status_t *message);
protocol_status_t command_ack_pack(const command_ack_t *message, can_frame_t *frame);
void command_ack_unpack(const can_frame_t *frame, command_ack_t *message);
protocol_status_t parameter_value_pack(const parameter_value_t *message, can_frame_t *frame);
void parameter_value_unpack(const can_frame_t *frame, parameter_value_t *message);
protocol_status_t firmware_identity_pack(const firmware_identity_t *message, can_frame_t *frame);
void firmware_identity_unpack(const can_frame_t *frame, firmware_identity_t *message);
protocol_status_t tick_trace_pack(const tick_trace_t *message, can_frame_t *frame);
void tick_trace_unpack(const can_frame_t *frame, tick_trace_t *message);
protocol_status_t firmware_heartbeat_pack(heartbeat_state_t state, can_frame_t *frame);

/* ---- operator <-> gripper: past the firmware, which does not use it */

typedef enum {
    GRIPPER_OPEN = 0,
    GRIPPER_CLOSE = 1,
} gripper_action_t;

typedef enum {
    GRIPPER_STATUS_MOVING = 0,
    GRIPPER_STATUS_OPEN = 1,
    GRIPPER_STATUS_CLOSED = 2,  /* on nothing */
    GRIPPER_STATUS_HOLDING = 3, /* an object is between the jaws */
} gripper_status_t;

typedef struct {
    uint8_t action;   /* gripper_action_t */
    uint8_t sequence; /* comes back in GripperState */
} gripper_command_t;

typedef struct {
    uint8_t sequence; /* of the last command; 0: there was none */
    gripper_status_t state;
    float opening_percent; /* 0 closed .. 100 */
    float force_N;         /* between jaws and object */
} gripper_state_t;

protocol_status_t gripper_command_pack(const gripper_command_t *message, can_frame_t *frame);
void gripper_command_unpack(const can_frame_t *frame, gripper_command_t *message);
protocol_status_t gripper_state_pack(const gripper_state_t *message, can_frame_t *frame);
void gripper_state_unpack(const can_frame_t *frame, gripper_state_t *message);

/* ---- proximity sensor -> operator */

typedef enum {
    PERSON_PART_HAND = 0,
    PERSON_PART_FOREARM = 1,
    PERSON_PART_CUP = 2,
    PERSON_PART_HELD = 3, /* the rod in the hand */
} person_part_t;

typedef enum { /* the arm with what it carries, then the rest */
               ROBOT_PART_FOREARM = 0,
               ROBOT_PART_GRIPPER = 1,
               ROBOT_PART_CUP = 2,
               ROBOT_PART_HELD = 3, /* the rod in the gripper */
               ROBOT_PART_UPPER_ARM = 4,
               ROBOT_PART_SHOULDER = 5,
               ROBOT_PART_TORSO = 6,
               ROBOT_PART_HEAD = 7,
} robot_part_t;

typedef struct {
    float person_m, self_m; /* least distance, 0..1.6383 */
    bool person_valid, self_valid;
    uint8_t person;      /* of the nearest person: number, 0 or 1 */
    uint8_t person_part; /* person_part_t */
    uint8_t robot_part;  /* robot_part_t, nearest to the person */
    uint8_t arm_part;    /* robot_part_t, FOREARM to HELD */
    uint8_t body_part;   /* what it is nearest to, as robot_part_t less ROBOT_PART_UPPER_ARM */
} clearance_report_t;

protocol_status_t clearance_report_pack(const clearance_report_t *message, can_frame_t *frame);
void clearance_report_unpack(const can_frame_t *frame, clearance_report_t *message);

#endif
