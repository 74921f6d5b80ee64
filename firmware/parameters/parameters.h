/* Every tunable of the firmware: named, with unit (in the name), range and default; checked before it is taken. */
#ifndef COMANIP_PARAMETERS_H
#define COMANIP_PARAMETERS_H

#include "../control/cooperation.h"
#include "../control/differential_ik.h"
#include "../control/joint_limits.h"
#include "../control/position_priority.h"
#include "../protocol/can_protocol.h"

/* Numbers and names are those of the DBC (ParameterValue.parameter). Vectors stand in a row: FIRST + component. */
typedef enum {
    PARAMETER_GAIN_PER_S = 0,   /* 8: diagonal of K, order of vec8 */
    PARAMETER_WEIGHT = 8,       /* 8: diagonal of W */
    PARAMETER_DAMPING = 16,     /* lambda */
    PARAMETER_ERROR_FRAME = 17, /* error_frame_t */
    PARAMETER_MOTION_SCALE = 18,
    PARAMETER_TRACKER_ROTATION_RAD = 19,         /* 3: rotation vector of q_Tv^E */
    PARAMETER_MARKER_TO_HAND_ROTATION_RAD = 22,  /* 3: rotation vector of the hand seen from the marker */
    PARAMETER_MARKER_TO_HAND_TRANSLATION_M = 25, /* 3 */
    PARAMETER_START_OFFSET_M = 28,               /* 3 */
    PARAMETER_LATCH_MEASURED = 31,               /* 0: latch the commanded q_task, 1: the measured one */
    PARAMETER_TASK_BLEND_S = 32,
    PARAMETER_SPEED_FRACTION = 33,
    PARAMETER_ACCELERATION_LIMIT_RADPS2 = 34,
    PARAMETER_COMMAND_DELAY_S = 35,
    PARAMETER_STALE_PERIODS = 36,
    PARAMETER_TRACE = 37, /* 1: TickTrace is sent */
    PARAMETER_PREDICTION =
        38, /* 1: the hand's motion is predicted and fed forward, position_priority.h; 0: interpolated, law (4) */
    PARAMETER_FOLLOWING_GAIN_PER_S = 39,  /* position_priority_config_t's K */
    PARAMETER_ORIENTATION_WEIGHT_M2 = 40, /* position_priority_config_t's w */
    PARAMETER_TRACKER_LATENCY_S = 41,     /* added to the latency that the tracker announces */
    PARAMETER_POSTURE_CHANGE = 42,        /* 1: with prediction, the arm leaves dead ends, posture_change.h */
    PARAMETER_COUNT = 43
} parameter_id_t;

typedef struct {
    const char *name;
    float minimum;
    float maximum;
    float default_value;
    bool integer; /* only whole numbers are taken */
} parameter_description_t;

extern const parameter_description_t parameter_table[PARAMETER_COUNT];

typedef struct {
    float value[PARAMETER_COUNT];
} parameters_t;

void parameters_set_defaults(parameters_t *self);

/* RESULT_ACCEPTED, RESULT_UNKNOWN_PARAMETER or RESULT_OUT_OF_RANGE (NaN included); a refused value changes nothing. */
result_t parameters_set(parameters_t *self, uint8_t parameter, float value);

/* Whether the hand's motion is predicted, and followed as position_priority.h has it. */
bool parameters_predict(const parameters_t *self);

/* Whether the arm changes its posture to get out of a dead end. */
bool parameters_change_posture(const parameters_t *self);

/* Views of the parameters as each stage wants them. */
void parameters_differential_ik(const parameters_t *self, differential_ik_config_t *config);
void parameters_position_priority(const parameters_t *self, position_priority_config_t *config);
void parameters_joint_limits(const parameters_t *self, const arm_t *arm, float tick_s, joint_limits_config_t *config);
void parameters_cooperation(const parameters_t *self, cooperation_config_t *config);
pose_t parameters_marker_to_hand(const parameters_t *self);

#endif
