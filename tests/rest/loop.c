/* Implements rest_run(): generates the frames to the firmware, reads its commands, models the drives, and records how
 * fast the joints are commanded to move after the hand has come to rest. */
#include "loop.h"

#include <math.h>
#include <string.h>

#include "../../firmware/control/arms/hoap3_right_ik.h"
#include "../../firmware/controller.h"

#define PI 3.14159265358979324
#define TICK_S 1e-3
#define PULSE_RAD (PI / 180.0 / 209.0)
#define HAND_PERIOD_TICKS 4
#define SELECT_TICK 60 /* by this tick, all drives and the tracker have sent frames */
#define START_TICK (SELECT_TICK + 1)
#define MOVE_TICK (START_TICK + 100)
#define DELAY_TICKS 8 /* greater than the longest dead time */

typedef struct {
    double position_rad, velocity_radps;
    double read_rad;             /* encoder reading at the time of the last command */
    double command[DELAY_TICKS]; /* ring of commands [rad/s] */
} drive_t;

typedef struct {
    const rest_case_t *work;
    rest_outcome_t *outcome;
    controller_t controller;
    controller_inbox_t inbox;
    protocol_sender_t drives, tracker, operator;
    drive_t drive[REST_JOINTS];
    double window_last[REST_JOINTS]; /* last velocity above REST_CREEP_RADPS in this window; 0: none so far */
    joint_cmd_t command;
} loop_t;

/* ---- frames to the firmware */

static void deliver(loop_t *self, protocol_sender_t *sender, can_frame_t *frame, uint32_t now_us) {
    frame->timestamp_us = now_us;
    protocol_protect(sender, frame);
    self->inbox.frame[self->inbox.count++] = *frame;
}

static double minimum_jerk(double s) {
    s = s < 0.0 ? 0.0 : (s > 1.0 ? 1.0 : s);
    return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

static void multiply(const double a[4], const double b[4], double product[4]) {
    product[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    product[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    product[2] = a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3];
    product[3] = a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1];
}

static void send_hand(loop_t *self, int tick, uint32_t now_us) {
    const rest_case_t *work = self->work;
    const double s = minimum_jerk((tick - MOVE_TICK) * TICK_S / work->move_s);
    const double angle = sqrt(work->turn_rad[0] * work->turn_rad[0] + work->turn_rad[1] * work->turn_rad[1] +
                              work->turn_rad[2] * work->turn_rad[2]);
    const double part = angle > 0.0 ? sin(0.5 * s * angle) / angle : 0.0;
    const double turned[4] = {cos(0.5 * s * angle), part * work->turn_rad[0], part * work->turn_rad[1],
                              part * work->turn_rad[2]};
    double rotation[4];
    multiply(turned, work->hand_rotation, rotation);
    const hand_pose_t pose = {
        .t_us = now_us,
        .position_m = {(float)(s * work->way_m[0]), (float)(s * work->way_m[1]), (float)(s * work->way_m[2])},
        .rotation = {(float)rotation[0], (float)rotation[1], (float)rotation[2], (float)rotation[3]},
        .valid = true,
    };
    can_frame_t frame;
    (void)hand_pose_pack(&pose, &frame);
    deliver(self, &self->tracker, &frame, now_us);
}

static void send_joints(loop_t *self, uint32_t now_us) {
    for (int i = 0; i < REST_JOINTS; i++) {
        const joint_state_t state = {
            .position_rad = (float)(nearbyint(self->drive[i].read_rad / PULSE_RAD) * PULSE_RAD),
            .velocity_radps = (float)self->drive[i].velocity_radps,
            .mode = self->command.mode[i],
            .temperature_degC = 35,
        };
        can_frame_t frame;
        (void)joint_state_pack(i, &state, &frame);
        deliver(self, &self->drives, &frame, now_us);
    }
}

static void send_operator(loop_t *self, int tick, uint32_t now_us) {
    if (tick == SELECT_TICK || tick == START_TICK) {
        const operator_command_t command = {.command = tick == SELECT_TICK ? COMMAND_SELECT : COMMAND_START,
                                            .sequence = (uint8_t)tick,
                                            .task = TASK_TELEOP};
        can_frame_t frame;
        (void)operator_command_pack(&command, &frame);
        deliver(self, &self->operator, &frame, now_us);
    }
}

/* ---- frames from the firmware */

static void take(void *context, const can_frame_t *frame) {
    loop_t *self = context;
    if (frame->id == frame_table[FRAME_JOINT_CMD].id) {
        joint_cmd_unpack(frame, &self->command);
    } else if (frame->id == frame_table[FRAME_COMMAND_ACK].id) {
        command_ack_t ack;
        command_ack_unpack(frame, &ack);
        if (ack.command == COMMAND_START) {
            self->outcome->start = ack.result;
        }
    }
}

/* ---- plant */

/* Advances a drive by the exact response of a first-order lag to a constant command. */
static void drive_advance(drive_t *self, double command_radps, double for_s, double lag_s) {
    const double left = exp(-for_s / lag_s);
    self->position_rad += command_radps * for_s + (self->velocity_radps - command_radps) * lag_s * (1.0 - left);
    self->velocity_radps = command_radps + (self->velocity_radps - command_radps) * left;
}

static void move_joints(loop_t *self, int tick) {
    const double dead_ticks = self->work->dead_time_s / TICK_S;
    const int whole = (int)dead_ticks;
    const double part_s = (dead_ticks - whole) * TICK_S; /* part of the tick in which the previous command still acts */
    for (int i = 0; i < REST_JOINTS; i++) {
        drive_t *drive = &self->drive[i];
        drive->command[tick % DELAY_TICKS] =
            self->command.mode[i] == DRIVE_MODE_VELOCITY ? (double)self->command.velocity_radps[i] : 0.0;
        drive->read_rad = drive->position_rad;
        const int acting = tick - whole + DELAY_TICKS;
        drive_advance(drive, drive->command[(acting - 1) % DELAY_TICKS], part_s, self->work->lag_s);
        drive_advance(drive, drive->command[acting % DELAY_TICKS], TICK_S - part_s, self->work->lag_s);
    }
}

/* ---- observation */

static void observe(loop_t *self, int tick) {
    for (int w = 0; w < REST_WINDOWS; w++) {
        const int end = MOVE_TICK + (int)lround(self->work->end_s[w] / TICK_S);
        const int begin = end - (int)lround(REST_WINDOW_S / TICK_S);
        if (tick < begin || tick >= end) {
            continue;
        }
        self->outcome->interrupted[w] += self->controller.supervisor.mode != MODE_COOPERATING;
        for (int i = 0; i < REST_JOINTS; i++) {
            const double velocity_radps = (double)self->command.velocity_radps[i];
            if (tick == begin) {
                self->window_last[i] = 0.0;
            }
            self->outcome->peak_radps[w][i] = fmax(self->outcome->peak_radps[w][i], fabs(velocity_radps));
            if (fabs(velocity_radps) > REST_CREEP_RADPS) {
                self->outcome->sign_changes[w][i] += velocity_radps * self->window_last[i] < 0.0;
                self->window_last[i] = velocity_radps;
            }
            self->outcome->position_rad[w][i] = self->drive[i].position_rad;
            self->outcome->velocity_radps[w][i] = velocity_radps;
        }
    }
}

static void finish(loop_t *self) {
    const pose_t *target = &self->controller.cooperation.target;
    const float numbers[7] = {target->rotation.w,     target->rotation.x,      target->rotation.y,
                              target->rotation.z,     target->translation_m.x, target->translation_m.y,
                              target->translation_m.z};
    for (int i = 0; i < 7; i++) {
        self->outcome->target[i] = (double)numbers[i];
    }
    self->outcome->mode = self->controller.supervisor.mode;
}

/* ---- a run */

static void run(loop_t *self) {
    controller_outbox_t outbox = {.sink = {.send = take, .context = self}};
    const int ticks = MOVE_TICK + (int)lround(self->work->end_s[REST_WINDOWS - 1] / TICK_S);
    for (int tick = 0; tick < ticks; tick++) {
        const uint32_t now_us = 1000u * (uint32_t)(tick + 1);
        self->inbox.count = 0;
        if (tick % HAND_PERIOD_TICKS == 0) {
            send_hand(self, tick, now_us);
        }
        send_joints(self, now_us);
        send_operator(self, tick, now_us);
        controller_step(&self->controller, now_us, &self->inbox, &outbox);
        if (tick == START_TICK && self->outcome->start != RESULT_ACCEPTED) {
            return;
        }
        observe(self, tick);
        move_joints(self, tick);
    }
    finish(self);
}

void rest_run(const parameters_t *parameters, const rest_case_t cases[], int count, rest_outcome_t outcomes[]) {
    static loop_t loop;
    for (int i = 0; i < count; i++) {
        memset(&loop, 0, sizeof loop);
        memset(&outcomes[i], 0, sizeof outcomes[i]);
        loop.work = &cases[i];
        loop.outcome = &outcomes[i];
        outcomes[i].start = RESULT_WRONG_MODE;
        for (int joint = 0; joint < REST_JOINTS; joint++) {
            loop.drive[joint].position_rad = loop.drive[joint].read_rad = cases[i].start_rad[joint];
        }
        controller_init(&loop.controller, &arm_ik_hoap3_right, CAN_PROFILE_FD);
        controller_set_parameters(&loop.controller, parameters, RESULT_ACCEPTED);
        outcomes[i].verdict = loop.controller.parameter_set.verdict;
        run(&loop);
    }
}
