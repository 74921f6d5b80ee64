#include "parameters.h"

#define PI 3.14159265358979324f

/* In the order of parameter_id_t. Gain, weights and damping of law (4): the best of a search over the five experiments
 * (docs/gains.md). With prediction 0 they give a 4-joint arm equal rates in all directions and near-exact position, at
 * the cost of orientation; weights of 1 in the torso frame are the paper. A higher gain lags less than these 29 ms, but
 * turns the tracker's noise into accelerations at the limit. The law with prediction: docs/control.md. */
const parameter_description_t parameter_table[PARAMETER_COUNT] = {
    /* name, minimum, maximum, default, whole numbers only */
    {"gain_w_per_s", 0.0f, 500.0f, 35.0f, false},
    {"gain_x_per_s", 0.0f, 500.0f, 35.0f, false},
    {"gain_y_per_s", 0.0f, 500.0f, 35.0f, false},
    {"gain_z_per_s", 0.0f, 500.0f, 35.0f, false},
    {"gain_dual_w_per_s", 0.0f, 500.0f, 35.0f, false},
    {"gain_dual_x_per_s", 0.0f, 500.0f, 35.0f, false},
    {"gain_dual_y_per_s", 0.0f, 500.0f, 35.0f, false},
    {"gain_dual_z_per_s", 0.0f, 500.0f, 35.0f, false},
    {"weight_w", 0.0f, 10000.0f, 0.01f, false},
    {"weight_x", 0.0f, 10000.0f, 0.01f, false},
    {"weight_y", 0.0f, 10000.0f, 0.01f, false},
    {"weight_z", 0.0f, 10000.0f, 0.01f, false},
    {"weight_dual_w", 0.0f, 10000.0f, 100.0f, false},
    {"weight_dual_x", 0.0f, 10000.0f, 100.0f, false},
    {"weight_dual_y", 0.0f, 10000.0f, 100.0f, false},
    {"weight_dual_z", 0.0f, 10000.0f, 100.0f, false},
    {"damping", 0.0f, 1.0f, 0.01f, false},
    {"error_frame", 0.0f, 1.0f, 1.0f, true},
    {"motion_scale", 0.01f, 10.0f, 1.0f, false},
    {"tracker_rotation_x_rad", -PI, PI, -0.5f * PI, false},
    {"tracker_rotation_y_rad", -PI, PI, 0.0f, false},
    {"tracker_rotation_z_rad", -PI, PI, 0.0f, false},
    {"marker_to_hand_rotation_x_rad", -PI, PI, 0.0f, false},
    {"marker_to_hand_rotation_y_rad", -PI, PI, 0.0f, false},
    {"marker_to_hand_rotation_z_rad", -PI, PI, 0.0f, false},
    {"marker_to_hand_translation_x_m", -1.0f, 1.0f, 0.0f, false},
    {"marker_to_hand_translation_y_m", -1.0f, 1.0f, 0.0f, false},
    {"marker_to_hand_translation_z_m", -1.0f, 1.0f, 0.0f, false},
    {"start_offset_x_m", -2.0f, 2.0f, 0.0f, false},
    {"start_offset_y_m", -2.0f, 2.0f, 0.0f, false},
    {"start_offset_z_m", -2.0f, 2.0f, 0.0f, false},
    {"latch_measured", 0.0f, 1.0f, 0.0f, true},
    {"task_blend_s", 0.0f, 60.0f, 1.0f, false},
    {"speed_fraction", 0.01f, 1.0f, 1.0f, false},
    {"acceleration_limit_radps2", 1.0f, 70.0f, 25.0f, false},
    {"command_delay_s", 0.0f, 0.05f, 0.005f, false},
    {"stale_periods", 1.5f, 25.0f, 2.5f, false},
    {"trace", 0.0f, 1.0f, 1.0f, true},
    {"prediction", 0.0f, 1.0f, 1.0f, true},
    {"following_gain_per_s", 1.0f, 60.0f, 35.0f, false},
    {"orientation_weight_m2", 0.0f, 1e-3f, 1.5e-5f, false},
    {"tracker_latency_s", -0.05f, 0.05f, 0.0f, false},
    {"posture_change", 0.0f, 1.0f, 0.0f, true},
};

void parameters_set_defaults(parameters_t *self) {
    for (int i = 0; i < PARAMETER_COUNT; i++) {
        self->value[i] = parameter_table[i].default_value;
    }
}

result_t parameters_set(parameters_t *self, uint8_t parameter, float value) {
    if (parameter >= PARAMETER_COUNT) {
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

/* Of the law in force. */
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
