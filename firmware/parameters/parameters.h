/* The tunable parameters of the firmware. Each has a name (with its unit), a range and a default; every new value is
 * checked. */
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
    bool integer; /* only whole numbers are accepted */
} parameter_description_t;

/* Indexed by parameter_id_t; generated from firmware/schema/parameters.toml. Unused numbers have no name. */
extern const parameter_description_t parameter_table[PARAMETER_COUNT];

typedef struct {
    float value[PARAMETER_COUNT];
} parameters_t;

/* Returns whether a parameter with this number exists. */
bool parameters_has(uint8_t parameter);

void parameters_set_defaults(parameters_t *self);

/* Returns RESULT_ACCEPTED, RESULT_UNKNOWN_PARAMETER or RESULT_OUT_OF_RANGE (also for NaN, and for a fraction if only
 * whole numbers are accepted). A refused value changes nothing. */
result_t parameters_set(parameters_t *self, uint8_t parameter, float value);

/* Returns whether the hand's motion is predicted, in which case position_priority() replaces the paper's inverse
 * kinematics. */
bool parameters_predict(const parameters_t *self);

/* Returns whether the arm may change its posture when joint limits block the target. */
bool parameters_change_posture(const parameters_t *self);

/* Derive each stage's configuration from the parameters. */
void parameters_differential_ik(const parameters_t *self, differential_ik_config_t *config);
void parameters_position_priority(const parameters_t *self, position_priority_config_t *config);
void parameters_joint_limits(const parameters_t *self, const arm_t *arm, float tick_s, joint_limits_config_t *config);
void parameters_cooperation(const parameters_t *self, cooperation_config_t *config);
pose_t parameters_marker_to_hand(const parameters_t *self);

#endif
