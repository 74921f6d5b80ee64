#include "controller.h"

#include <stddef.h>
#include <string.h>

#include "comanip_build_hash.h"

#define UNIT_TOLERANCE 1e-3f
#define TRACED_AGE_MAX_US 0xFFFFFFu /* TickTrace has 24 bits for it */

/* A target that was lost is met with this part of the joints' speeds, until the hand is as near to it as this. */
#define CATCHING_UP_SPEED 0.55f
#define CAUGHT_UP_M 1e-3f

#define LISTENS_TO                                                                                                     \
    (UINT32_C(1) << FRAME_HAND_POSE | UINT32_C(1) << FRAME_TRACKER_STATUS | UINT32_C(0xFF) << FRAME_JOINT_STATE0 |     \
     UINT32_C(1) << FRAME_OPERATOR_COMMAND | UINT32_C(1) << FRAME_TASK_DEFINE | UINT32_C(1) << FRAME_PARAMETER_ACCESS)

static float tick_s(const controller_t *self) {
    return 1e-3f * (float)self->tick_ms;
}

/* ---- decode */

static void apply_parameters(controller_t *self) {
    parameters_differential_ik(&self->parameters, &self->differential_ik_config);
    parameters_position_priority(&self->parameters, &self->position_priority_config);
    parameters_joint_limits(&self->parameters, self->arm, tick_s(self), &self->joint_limits_config);
    parameters_cooperation(&self->parameters, &self->cooperation_config);
    self->marker_to_hand = parameters_marker_to_hand(&self->parameters);
    self->predicts = parameters_predict(&self->parameters);
    self->changes_posture = parameters_change_posture(&self->parameters);
    hand_tracker_interpolate(&self->hand_tracker, !self->predicts);
    if (!self->predicts) { /* switched on again, prediction begins with the next sample */
        hand_motion_init(&self->marker_motion);
    }
    self->marker_is_hand = memcmp(&self->marker_to_hand, &pose_identity, sizeof pose_identity) == 0;
    self->parameter_set = parameter_set_check(&self->parameters, tick_s(self));
    self->unreported = 0;
}

static void receive_hand(controller_t *self, const hand_pose_t *pose, uint32_t received_us, uint32_t now_us) {
    if (!hand_tracker_receive(&self->hand_tracker, pose, received_us, now_us)) {
        self->receiver.protocol.rejected += pose->valid;
        return;
    }
    if (self->predicts) {
        const int32_t later_us = (int32_t)(1e6f * self->parameters.value[PARAMETER_TRACKER_LATENCY_S]);
        const uint32_t captured_us = hand_tracker_captured_us(&self->hand_tracker) - (uint32_t)later_us;
        hand_motion_sample(&self->marker_motion, hand_tracker_newest(&self->hand_tracker), captured_us, now_us);
    }
}

/* Measurements are taken over at once; the operator's frames wait until this tick's poses are known. */
static void decode(controller_t *self, uint32_t now_us, controller_inbox_t *inbox) {
    self->request_count = 0;
    for (uint8_t i = 0; i < inbox->count; i++) {
        can_frame_t *frame = &inbox->frame[i];
        frame_kind_t kind;
        if (transport_receive(&self->receiver, frame, &kind) != PROTOCOL_OK) {
            continue;
        }
        bool after_now = (int32_t)(now_us - frame->timestamp_us) < 0;
        uint32_t received_us = after_now ? now_us : frame->timestamp_us;
        if (kind == FRAME_HAND_POSE) {
            hand_pose_t pose;
            hand_pose_unpack(frame, &pose);
            receive_hand(self, &pose, received_us, now_us);
        } else if (kind == FRAME_TRACKER_STATUS) {
            tracker_status_t status;
            tracker_status_unpack(frame, &status);
            hand_tracker_status(&self->hand_tracker, &status);
        } else if (kind >= FRAME_JOINT_STATE0 && kind <= FRAME_JOINT_STATE7) {
            joint_state_t state;
            joint_state_unpack(frame, &state);
            joint_feedback_receive(&self->joints, (int)kind - (int)FRAME_JOINT_STATE0, &state, received_us);
        } else if (kind == FRAME_OPERATOR_COMMAND || kind == FRAME_TASK_DEFINE || kind == FRAME_PARAMETER_ACCESS) {
            self->request[self->request_count].kind = kind;
            self->request[self->request_count++].index = i;
        }
    }
}

/* ---- hand and robot, this tick */

/* The encoders were sampled a tick ago, as the last command arrived: with prediction, once it has begun, the hand is
 * taken as it was then. */
static void sense(controller_t *self, uint32_t now_us) {
    if (self->predicts && self->marker_motion.is_running) {
        self->hand = hand_motion_pose(&self->marker_motion, now_us, -tick_s(self));
        if (!self->marker_is_hand) {
            const vector3_t marker_m = self->hand.translation_m;
            self->hand = pose_multiply(self->hand, self->marker_to_hand);
            self->lever_m = vector3_add(self->hand.translation_m, vector3_scale(marker_m, -1.0f));
        }
    } else {
        self->hand = pose_multiply(hand_tracker_pose(&self->hand_tracker, now_us), self->marker_to_hand);
        self->lever_m = (vector3_t){0.0f, 0.0f, 0.0f};
    }
}

/* The motion of the person's hand when this tick's command acts. The lever turns on until then. */
static twist_t hand_motion(const controller_t *self, uint32_t now_us) {
    const float ahead_s = self->parameters.value[PARAMETER_COMMAND_DELAY_S];
    const twist_t marker = hand_motion_twist(&self->marker_motion, now_us, ahead_s);
    if (self->marker_is_hand) {
        return marker;
    }
    const vector3_t turning_mps = vector3_cross(marker.angular_velocity_radps, self->lever_m);
    const vector3_t lever_m = vector3_add(self->lever_m, vector3_scale(turning_mps, tick_s(self) + ahead_s));
    return (twist_t){vector3_add(marker.velocity_mps, vector3_cross(marker.angular_velocity_radps, lever_m)),
                     marker.angular_velocity_radps};
}

/* The robot's measured hand in the torso frame, this tick: asked for only where a reference is taken. */
static pose_t robot_pose(const controller_t *self) {
    return self->arm->forward_kinematics(self->arm, self->joints.position_rad);
}

static void supervise(controller_t *self, uint32_t now_us) {
    self->supervisor_inputs = (supervisor_inputs_t){
        .drives_fresh = joint_feedback_check_fresh(&self->joints, self->arm->joint_count, now_us),
        .drive_error = joint_feedback_has_error(&self->joints, self->arm->joint_count),
        .tracker_fresh =
            !hand_tracker_check_stale(&self->hand_tracker, now_us, self->parameters.value[PARAMETER_STALE_PERIODS]),
        .finite = self->finite,
    };
    supervisor_update(&self->supervisor, &self->supervisor_inputs);
    if (!self->hand_tracker.has_pose) {
        hand_motion_reset(&self->marker_motion);
    }
}

/* ---- operator */

static bool is_engaged(const controller_t *self) {
    return self->supervisor.mode == MODE_COOPERATING || self->supervisor.mode == MODE_HOLD;
}

/* 0 to 1 with minimum jerk, as the selected task comes into force. */
static float blend(const controller_t *self) {
    if (self->blend_elapsed_s >= self->blend_s) {
        return 1.0f;
    }
    float s = self->blend_elapsed_s / self->blend_s;
    return s * s * s * (10.0f + s * (6.0f * s - 15.0f));
}

/* What the law would say of a target that is the robot's own pose: nothing for the error. The target's motion goes on.
 */
static void zero_feedback(controller_t *self) {
    memset(self->feedback_radps, 0, sizeof self->feedback_radps);
}

static void zero_demand(controller_t *self) {
    zero_feedback(self);
    memset(self->feedforward_radps, 0, sizeof self->feedforward_radps);
    self->catching_up = false;
}

static void select_task(controller_t *self, task_id_t id, const task_t *task, float blend_s) {
    self->task_id = id;
    self->task = *task;
    self->blend_s = blend_s;
    self->blend_elapsed_s = 0.0f;
    if (is_engaged(self)) {
        cooperation_select(&self->cooperation, task);
        self->cooperation_changed = true;
    }
}

/* They may be written, one by one, but not be driven or kept. Whose request this refuses is told of each parameter
 * involved. */
static result_t stable_required(controller_t *self, uint8_t sequence) {
    if (self->parameter_set.verdict != PARAMETER_SET_UNSTABLE) {
        return RESULT_ACCEPTED;
    }
    self->unreported = self->parameter_set.involved;
    self->unreported_sequence = sequence;
    return RESULT_PARAMETERS_UNSTABLE;
}

static result_t start(controller_t *self, uint8_t sequence) {
    const result_t refusal = stable_required(self, sequence);
    result_t result = refusal != RESULT_ACCEPTED ? refusal : supervisor_start(&self->supervisor);
    if (result == RESULT_ACCEPTED) {
        self->blend_elapsed_s = 0.0f;
        cooperation_start(&self->cooperation, &self->cooperation_config, &self->task, self->hand, robot_pose(self));
        self->cooperation_changed = true;
        zero_demand(self);
    }
    return result;
}

/* Latch and clutch need the person's hand, so cooperation that is not held. */
static result_t cooperation_required(const controller_t *self) {
    switch (self->supervisor.mode) {
    case MODE_COOPERATING: return RESULT_ACCEPTED;
    case MODE_HOLD: return RESULT_TRACKER_STALE;
    default: return RESULT_WRONG_MODE;
    }
}

static result_t latch(controller_t *self) {
    result_t result = cooperation_required(self);
    if (result == RESULT_ACCEPTED) {
        if (self->parameters.value[PARAMETER_LATCH_MEASURED] > 0.0f) {
            cooperation_update(&self->cooperation, &self->hand, blend(self)); /* the virtual hand of this tick */
            cooperation_latch_measured(&self->cooperation, robot_pose(self));
            zero_feedback(self);
        } else {
            cooperation_latch(&self->cooperation);
        }
        self->cooperation_changed = true;
    }
    return result;
}

static result_t clutch(controller_t *self) {
    result_t result = cooperation_required(self);
    if (result == RESULT_ACCEPTED) {
        cooperation_clutch(&self->cooperation, self->hand, robot_pose(self), blend(self));
        self->cooperation_changed = true;
        zero_feedback(self);
    }
    return result;
}

static result_t select_built_in(controller_t *self, uint8_t number) {
    const task_t *task = task_built_in(number);
    if (task == NULL) {
        return RESULT_UNKNOWN_TASK;
    }
    select_task(self, (task_id_t)number, task, self->parameters.value[PARAMETER_TASK_BLEND_S]);
    return RESULT_ACCEPTED;
}

static result_t command_result(controller_t *self, const operator_command_t *command) {
    switch (command->command) {
    case COMMAND_SELECT: return select_built_in(self, command->task);
    case COMMAND_START: return start(self, command->sequence);
    case COMMAND_LATCH: return latch(self);
    case COMMAND_CLUTCH: return clutch(self);
    case COMMAND_STOP: return supervisor_stop(&self->supervisor, &self->supervisor_inputs);
    default: return RESULT_UNKNOWN_COMMAND;
    }
}

static result_t define_result(controller_t *self, const task_define_t *define) {
    if (define->form > TASK_FORM_MIRRORED) {
        return RESULT_OUT_OF_RANGE;
    }
    if (!quaternion_is_unit(define->q_task, UNIT_TOLERANCE) || !quaternion_is_unit(define->q_inv, UNIT_TOLERANCE)) {
        return RESULT_NOT_A_UNIT_QUATERNION;
    }
    task_t task = {
        .form = (task_form_t)define->form,
        .t_task_m = define->t_task_m,
        .q_task = quaternion_normalise(define->q_task),
        .q_inv = quaternion_normalise(define->q_inv),
    };
    select_task(self, TASK_CUSTOM, &task, define->blend_s);
    return RESULT_ACCEPTED;
}

/* Parameters change at standstill only: a gain or a tracker rotation that changes in motion is a jump of the target. */
static bool may_change_parameters(const controller_t *self) {
    return !is_engaged(self) && joint_limits_at_rest(&self->limits, self->arm);
}

static result_t access_result(controller_t *self, const parameter_access_t *access) {
    if (access->parameter >= PARAMETER_COUNT) {
        return RESULT_UNKNOWN_PARAMETER;
    }
    if (access->operation == PARAMETER_READ) {
        return RESULT_ACCEPTED;
    }
    if (access->operation != PARAMETER_WRITE) {
        return RESULT_UNKNOWN_COMMAND;
    }
    if (!may_change_parameters(self)) {
        return RESULT_WRONG_MODE;
    }
    result_t result = parameters_set(&self->parameters, access->parameter, access->value);
    if (result == RESULT_ACCEPTED) {
        apply_parameters(self);
    }
    return result;
}

static void send(controller_t *self, controller_outbox_t *outbox, can_frame_t *frame) {
    (void)transport_send(&self->sender, frame, &outbox->sink); /* values that classic CAN cannot carry stay unsent */
}

static void send_ack(controller_t *self, controller_outbox_t *outbox, uint8_t command, uint8_t sequence,
                     result_t result) {
    can_frame_t frame;
    (void)command_ack_pack(&(command_ack_t){.command = command, .sequence = sequence, .result = result}, &frame);
    send(self, outbox, &frame);
}

static void send_parameter(controller_t *self, controller_outbox_t *outbox, uint8_t parameter, uint8_t sequence,
                           result_t result) {
    can_frame_t frame;
    parameter_value_t message = {
        .parameter = parameter,
        .sequence = sequence,
        .result = result,
        .value = parameter < PARAMETER_COUNT ? self->parameters.value[parameter] : 0.0f,
    };
    (void)parameter_value_pack(&message, &frame);
    send(self, outbox, &frame);
}

/* What the boot announcement says of a parameter. */
static result_t announced_result(const controller_t *self, uint8_t parameter) {
    const bool unstable =
        self->parameter_set.verdict == PARAMETER_SET_UNSTABLE && (self->parameter_set.involved >> parameter & 1u) != 0u;
    return unstable ? RESULT_PARAMETERS_UNSTABLE : self->boot_result;
}

/* A parameter that is written before its turn is announced first, so that what was in force at boot is on the bus, and
 * a replay can begin with it. */
static void access_parameter(controller_t *self, controller_outbox_t *outbox, const parameter_access_t *access) {
    const bool announced = access->parameter + 1u < self->announced;
    if (access->operation == PARAMETER_WRITE && access->parameter < PARAMETER_COUNT && !announced) {
        send_parameter(self, outbox, access->parameter, 0, announced_result(self, access->parameter));
    }
    send_parameter(self, outbox, access->parameter, access->sequence, access_result(self, access));
}

/* Answered when it is over; a request that is repeated meanwhile is the same one. Not in motion: the machine has better
 * things to do then. */
static void begin_save(controller_t *self, controller_outbox_t *outbox, const parameter_access_t *access) {
    if (self->saving && access->sequence == self->save_sequence) {
        return;
    }
    const bool may_save = !self->saving && may_change_parameters(self);
    const result_t result = may_save ? stable_required(self, access->sequence) : RESULT_WRONG_MODE;
    if (result != RESULT_ACCEPTED) {
        send_parameter(self, outbox, access->parameter, access->sequence, result);
        return;
    }
    self->saving = true;
    self->save_parameter = access->parameter;
    self->save_sequence = access->sequence;
    outbox->save = true;
}

static void end_save(controller_t *self, const controller_inbox_t *inbox, controller_outbox_t *outbox) {
    if (self->saving && inbox->save_over) {
        self->saving = false;
        send_parameter(self, outbox, self->save_parameter, self->save_sequence, inbox->save_result);
    }
}

/* From the tick after the refusal on, one a tick, so that they do not crowd the bus. */
static void report_unstable_parameter(controller_t *self, controller_outbox_t *outbox) {
    if (self->unreported == 0u) {
        return;
    }
    uint8_t parameter = 0;
    while ((self->unreported >> parameter & 1u) == 0u) {
        parameter++;
    }
    send_parameter(self, outbox, parameter, self->unreported_sequence, RESULT_PARAMETERS_UNSTABLE);
    self->unreported &= self->unreported - 1u;
}

/* Each request but that to save is answered in the tick that takes it. */
static void handle_requests(controller_t *self, const controller_inbox_t *inbox, controller_outbox_t *outbox) {
    for (uint8_t i = 0; i < self->request_count; i++) {
        const can_frame_t *frame = &inbox->frame[self->request[i].index];
        if (self->request[i].kind == FRAME_OPERATOR_COMMAND) {
            operator_command_t command;
            operator_command_unpack(frame, &command);
            send_ack(self, outbox, command.command, command.sequence, command_result(self, &command));
        } else if (self->request[i].kind == FRAME_TASK_DEFINE) {
            task_define_t define;
            task_define_unpack(frame, &define);
            send_ack(self, outbox, COMMAND_DEFINE, define.sequence, define_result(self, &define));
        } else {
            parameter_access_t access;
            parameter_access_unpack(frame, &access);
            if (access.operation == PARAMETER_SAVE) {
                begin_save(self, outbox, &access);
            } else {
                access_parameter(self, outbox, &access);
            }
        }
    }
}

/* ---- Algorithm 1 and law (4) */

/* All joints in proportion, so that the hand keeps its direction. */
static void slow_down(controller_t *self) {
    const float part = CATCHING_UP_SPEED * self->parameters.value[PARAMETER_SPEED_FRACTION];
    float scale = 1.0f;
    for (int i = 0; i < self->arm->joint_count; i++) {
        const float speed_radps = __builtin_fabsf(self->feedback_radps[i] + self->feedforward_radps[i]);
        const float allowed_radps = part * self->arm->joints[i].velocity_max_radps;
        if (scale * speed_radps > allowed_radps) {
            scale = allowed_radps / speed_radps;
        }
    }
    for (int i = 0; i < self->arm->joint_count; i++) {
        self->feedback_radps[i] *= scale;
        self->feedforward_radps[i] *= scale;
    }
}

static void follow(controller_t *self, uint32_t now_us, joint_ends_t ends) {
    const twist_t hand = hand_motion(self, now_us);
    const twist_t motion = cooperation_target_motion(&self->cooperation, &hand);
    const position_priority_request_t request = {
        .position_rad = self->joints.position_rad,
        .target = &self->cooperation.target,
        .motion = &motion,
        .ends = ends,
    };
    const posture_change_config_t config = {self->arm, &self->position_priority_config, &self->joint_limits_config};
    const bool may_change_posture = self->changes_posture && !self->cooperation.latched;
    if (may_change_posture && posture_change_step(&self->posture_change, &config, &request, self->feedback_radps)) {
        memset(self->feedforward_radps, 0, sizeof self->feedforward_radps);
        return;
    }
    const float distance_m = self->arm->position_priority(self->arm, &self->position_priority_config, &request,
                                                          self->feedback_radps, self->feedforward_radps);
    if (may_change_posture) {
        posture_change_watch(&self->posture_change, &config, &request, distance_m);
    }
    self->catching_up = distance_m > POSITION_PRIORITY_ERROR_MAX_M || (self->catching_up && distance_m > CAUGHT_UP_M);
    if (self->catching_up) {
        slow_down(self);
    }
}

static void velocity_law(controller_t *self, joint_ends_t ends) {
    const differential_ik_request_t request = {
        .position_rad = self->joints.position_rad,
        .target = &self->cooperation.target,
        .ends = ends,
    };
    differential_ik(self->arm, &self->differential_ik_config, &request, self->feedback_radps);
}

/* What the joints shall do: nothing, unless in cooperation. The law waits in a tick in which the cooperation changes,
 * as both would make it too long; never twice running, so that whoever goes on changing does not stop the law. */
static void compute_demand(controller_t *self, uint32_t now_us) {
    const bool was_deferred = self->demand_deferred;
    self->demand_deferred = false;
    if (self->supervisor.mode != MODE_COOPERATING || self->cooperation_changed) {
        posture_change_init(&self->posture_change);
    }
    if (self->supervisor.mode != MODE_COOPERATING) {
        zero_demand(self);
        return;
    }
    if (self->cooperation_changed && !was_deferred) {
        self->demand_deferred = true;
        return;
    }
    cooperation_update(&self->cooperation, &self->hand, blend(self));
    self->blend_elapsed_s += self->blend_elapsed_s < self->blend_s ? tick_s(self) : 0.0f;
    const joint_ends_t ends = joint_limits_ends(self->arm, &self->joint_limits_config, self->joints.position_rad);
    if (self->predicts) {
        follow(self, now_us, ends);
    } else {
        velocity_law(self, ends);
    }
}

/* ---- encode */

static void send_joint_command(controller_t *self, controller_outbox_t *outbox) {
    /* A stop is driven to its end before the brakes close. */
    bool moving = is_engaged(self) || !joint_limits_at_rest(&self->limits, self->arm);
    joint_cmd_t command = {0}; /* braked */
    for (int i = 0; i < self->arm->joint_count; i++) {
        command.mode[i] = moving ? DRIVE_MODE_VELOCITY : DRIVE_MODE_BRAKE;
        command.position_rad[i] = self->limits.position_rad[i];
        command.velocity_radps[i] = self->limits.velocity_radps[i];
    }
    can_frame_t frame;
    if (joint_cmd_pack(&command, &frame) == PROTOCOL_OK) {
        send(self, outbox, &frame);
    } else {
        self->finite = false; /* arm_check() keeps the limits within the frame: only a defect leads here */
    }
}

static const pose_t no_target = {{0.0f, 0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}};

static void send_trace(controller_t *self, uint32_t now_us, controller_outbox_t *outbox) {
    tick_trace_t trace; /* all of it is set here: an initialiser would first write zeros */
    trace.now_us = now_us;
    trace.target_valid = self->supervisor.mode == MODE_COOPERATING;
    trace.target = trace.target_valid ? self->cooperation.target : no_target;
    const uint32_t age_us = hand_tracker_age_us(&self->hand_tracker, now_us);
    trace.hand_age_us = age_us < TRACED_AGE_MAX_US ? age_us : TRACED_AGE_MAX_US;
    trace.drives_fresh = self->supervisor_inputs.drives_fresh;
    trace.rejected_frames = (uint8_t)self->receiver.protocol.rejected;
    protocol_trace_inputs(self->receiver.protocol.e2e, &trace);
    can_frame_t frame;
    (void)tick_trace_pack(&trace, &frame);
    send(self, outbox, &frame);
}

static void send_status(controller_t *self, controller_outbox_t *outbox) {
    firmware_status_t status = {
        .mode = self->supervisor.mode,
        .reason = self->supervisor.reason,
        .stop_category = supervisor_stop_category(&self->supervisor),
        .task = self->task_id,
        .latched = is_engaged(self) && self->cooperation.latched,
        .rest_not_assured = self->parameter_set.verdict != PARAMETER_SET_RESTS,
        .changes_posture = posture_change_is_moving(&self->posture_change),
        .speed_limit_percent = 100.0f * self->parameters.value[PARAMETER_SPEED_FRACTION],
        .rejected_frames = (uint8_t)self->receiver.protocol.rejected,
    };
    can_frame_t frame;
    (void)firmware_status_pack(&status, &frame);
    send(self, outbox, &frame);
}

static void send_heartbeat(controller_t *self, controller_outbox_t *outbox) {
    heartbeat_state_t state = self->announced == 0u                 ? HEARTBEAT_BOOT_UP
                              : self->supervisor.mode == MODE_FAULT ? HEARTBEAT_STOPPED
                              : self->supervisor.mode == MODE_IDLE  ? HEARTBEAT_PRE_OPERATIONAL
                                                                    : HEARTBEAT_OPERATIONAL;
    can_frame_t frame;
    (void)firmware_heartbeat_pack(&(firmware_heartbeat_t){state}, &frame);
    send(self, outbox, &frame);
}

/* At boot: who this is, then all parameters, one frame a tick. */
static void announce(controller_t *self, controller_outbox_t *outbox) {
    if (self->announced == 0u) {
        firmware_identity_t identity = {
            .build_hash = COMANIP_BUILD_HASH,
            .arm = self->arm->id,
            .joint_count = self->arm->joint_count,
            .parameter_count = PARAMETER_COUNT,
        };
        can_frame_t frame;
        (void)firmware_identity_pack(&identity, &frame);
        send(self, outbox, &frame);
    } else if (self->announced <= PARAMETER_COUNT) {
        const uint8_t parameter = (uint8_t)(self->announced - 1u);
        send_parameter(self, outbox, parameter, 0, announced_result(self, parameter));
    } else {
        return;
    }
    self->announced++;
}

static bool is_due(const controller_t *self, frame_kind_t kind) {
    return self->tick * self->tick_ms % transport_period_ms(self->sender.profile, kind) == 0u;
}

static void encode(controller_t *self, uint32_t now_us, controller_outbox_t *outbox) {
    send_joint_command(self, outbox);
    if (self->parameters.value[PARAMETER_TRACE] > 0.0f) {
        send_trace(self, now_us, outbox);
    }
    if (is_due(self, FRAME_FIRMWARE_STATUS)) {
        send_status(self, outbox);
    }
    if (is_due(self, FRAME_FIRMWARE_HEARTBEAT)) {
        send_heartbeat(self, outbox);
    }
    announce(self, outbox);
}

/* ---- the pipeline */

void controller_init(controller_t *self, const arm_t *arm, can_profile_t profile) {
    memset(self, 0, sizeof *self);
    self->arm = arm;
    self->tick_ms = transport_period_ms(profile, FRAME_JOINT_CMD);
    transport_sender_init(&self->sender, profile, arm->joint_count);
    transport_receiver_init(&self->receiver, profile, arm->joint_count, LISTENS_TO);
    hand_tracker_init(&self->hand_tracker, 1000u * transport_period_ms(profile, FRAME_HAND_POSE));
    hand_motion_init(&self->marker_motion);
    joint_feedback_init(&self->joints, 1000u * transport_timeout_ms(profile, FRAME_JOINT_STATE0));
    supervisor_init(&self->supervisor);
    posture_change_init(&self->posture_change);
    joint_limits_init(&self->limits);
    self->finite = true;
    parameters_t defaults;
    parameters_set_defaults(&defaults);
    controller_set_parameters(self, &defaults, RESULT_ACCEPTED);
}

void controller_set_parameters(controller_t *self, const parameters_t *parameters, result_t result) {
    self->parameters = *parameters;
    self->boot_result = result;
    apply_parameters(self);
    select_task(self, TASK_TELEOP, &task_table[TASK_TELEOP], self->parameters.value[PARAMETER_TASK_BLEND_S]);
}

void controller_step(controller_t *self, uint32_t now_us, controller_inbox_t *inbox, controller_outbox_t *outbox) {
    outbox->save = false;
    self->cooperation_changed = false;
    decode(self, now_us, inbox);
    sense(self, now_us);
    supervise(self, now_us);
    end_save(self, inbox, outbox);
    report_unstable_parameter(self, outbox);
    handle_requests(self, inbox, outbox);
    compute_demand(self, now_us);
    self->finite = joint_limits_apply(&self->limits, self->arm, &self->joint_limits_config, self->joints.position_rad,
                                      self->feedback_radps, self->feedforward_radps);
    encode(self, now_us, outbox);
    self->tick++;
}
