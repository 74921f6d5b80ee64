/* The table of parameters, and the configurations derived from them: see parameters.h. */
#include "parameters.h"

#include <stddef.h>

#define ROW(number, name, minimum, maximum, default_value, integer, unit, group, meaning)                              \
    [number] = {name, minimum, maximum, default_value, integer},
const parameter_description_t parameter_table[PARAMETER_COUNT] = {COMANIP_PARAMETERS(ROW)};

bool parameters_has(uint8_t parameter) {
    return parameter < PARAMETER_COUNT && parameter_table[parameter].name != NULL;
}

void parameters_set_defaults(parameters_t *self) {
    for (int i = 0; i < PARAMETER_COUNT; i++) {
        self->value[i] = parameter_table[i].default_value;
    }
}

result_t parameters_set(parameters_t *self, uint8_t parameter, float value) {
    if (!parameters_has(parameter)) {
        return RESULT_UNKNOWN_PARAMETER;
    }
    const parameter_description_t *description = &parameter_table[parameter];
    if (!(value >= description->minimum && value <= description->maximum)) {
        return RESULT_OUT_OF_RANGE;
    }
    if (description->integer && value != (float)(int32_t)value) {
        return RESULT_OUT_OF_RANGE;
    }
    self->value[parameter] = value;
    return RESULT_ACCEPTED;
}

bool parameters_predict(const parameters_t *self) {
    return self->value[PARAMETER_PREDICTION] > 0.0f;
}

bool parameters_change_posture(const parameters_t *self) {
    return self->value[PARAMETER_POSTURE_CHANGE] > 0.0f;
}

static vector3_t vector_at(const parameters_t *self, int first) {
    return (vector3_t){self->value[first], self->value[first + 1], self->value[first + 2]};
}

void parameters_differential_ik(const parameters_t *self, differential_ik_config_t *config) {
    for (int i = 0; i < 8; i++) {
        config->gain_per_s[i] = self->value[PARAMETER_GAIN_PER_S + i];
        config->weight[i] = self->value[PARAMETER_WEIGHT + i];
    }
    config->damping = self->value[PARAMETER_DAMPING];
    config->error_frame = self->value[PARAMETER_ERROR_FRAME] > 0.0f ? ERROR_FRAME_TARGET : ERROR_FRAME_TORSO;
    differential_ik_prepare(config);
}

void parameters_position_priority(const parameters_t *self, position_priority_config_t *config) {
    config->gain_per_s = self->value[PARAMETER_FOLLOWING_GAIN_PER_S];
    config->orientation_weight_m2 = self->value[PARAMETER_ORIENTATION_WEIGHT_M2];
}

/* Returns the largest gain of the inverse kinematics in use. */
static float largest_gain_per_s(const parameters_t *self) {
    if (parameters_predict(self)) {
        return self->value[PARAMETER_FOLLOWING_GAIN_PER_S];
    }
    float largest = 0.0f;
    for (int i = 0; i < 8; i++) {
        float gain = self->value[PARAMETER_GAIN_PER_S + i];
        largest = gain > largest ? gain : largest;
    }
    return largest;
}

void parameters_joint_limits(const parameters_t *self, const arm_t *arm, float tick_s, joint_limits_config_t *config) {
    config->tick_s = tick_s;
    config->speed_fraction = self->value[PARAMETER_SPEED_FRACTION];
    config->acceleration_max_radps2 = self->value[PARAMETER_ACCELERATION_LIMIT_RADPS2];
    config->command_delay_s = self->value[PARAMETER_COMMAND_DELAY_S];
    config->approach_gain_per_s = largest_gain_per_s(self);
    joint_limits_prepare(config, arm);
}

void parameters_cooperation(const parameters_t *self, cooperation_config_t *config) {
    config->tracker_rotation = quaternion_from_rotation_vector(vector_at(self, PARAMETER_TRACKER_ROTATION_RAD));
    config->start_offset_m = vector_at(self, PARAMETER_START_OFFSET_M);
    config->motion_scale = self->value[PARAMETER_MOTION_SCALE];
}

pose_t parameters_marker_to_hand(const parameters_t *self) {
    return (pose_t){
        quaternion_from_rotation_vector(vector_at(self, PARAMETER_MARKER_TO_HAND_ROTATION_RAD)),
        vector_at(self, PARAMETER_MARKER_TO_HAND_TRANSLATION_M),
    };
}
