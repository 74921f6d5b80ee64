/* Every tunable of the firmware: named, with unit (in the name), range and default; checked before it is taken. */
#ifndef COMANIP_PARAMETERS_H
#define COMANIP_PARAMETERS_H

#include "../control/cooperation.h"
#include "../control/differential_ik.h"
#include "../control/joint_limits.h"
#include "../control/position_priority.h"
#include "../protocol/messages.h"
#include "comanip_parameters.h"

typedef struct {
    const char *name;
    float minimum;
    float maximum;
    float default_value;
    bool integer; /* only whole numbers are taken */
} parameter_description_t;

/* By parameter_id_t, from firmware/schema/parameters.toml; a number that no parameter has is without a name. */
extern const parameter_description_t parameter_table[PARAMETER_COUNT];

typedef struct {
    float value[PARAMETER_COUNT];
} parameters_t;

/* Whether there is a parameter of this number. */
bool parameters_has(uint8_t parameter);

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
