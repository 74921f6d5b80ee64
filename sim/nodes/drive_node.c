#include "drive_node.h"

#include <math.h>
#include <stdlib.h>

#include "../bus/endpoint.h"

#define PULSES_PER_RAD (ROBOT_PULSES_PER_DEGREE / ROBOT_RAD_PER_DEG)
#define VELOCITY_WINDOW 8 /* samples per velocity estimate; at 1 kHz, the resolution is about 12 mrad/s */
#define TEMPERATURE_DEGC 35
#define NS_PER_S 1e9

typedef struct {
    double commanded_radps; /* latched command */
    double servo_radps;     /* velocity after the servo's lag */
    double pulses[VELOCITY_WINDOW];
    drive_mode_t mode;
} drive_t;

struct drive_node {
    endpoint_t endpoint;
    int64_t timeout_ns; /* timeout of JointCmd */
    int64_t period_ns;  /* period of JointState */
    arm_plant_t *plant;
    drive_t drive[ROBOT_JOINTS];
    int64_t sample_ns[VELOCITY_WINDOW];
    int samples; /* number of samples taken, up to VELOCITY_WINDOW */
    int newest;
    bool enabled;   /* state of the enable line */
    bool commanded; /* a JointCmd has been received */
    bool timed_out;
    int64_t command_ns;
};

/* Returns the encoder reading in whole pulses, with the sign of the joint angle. The manual's counting directions
 * (+ + - -) are not modelled, because they are internal to the drives: the bus carries radians. */
static double encoder_pulses(const drive_node_t *self, int joint) {
    return nearbyint(arm_plant_position_rad(self->plant, joint) * PULSES_PER_RAD);
}

static void sample_encoders(drive_node_t *self, int64_t now_ns) {
    self->newest = (self->newest + 1) % VELOCITY_WINDOW;
    self->samples += self->samples < VELOCITY_WINDOW ? 1 : 0;
    self->sample_ns[self->newest] = now_ns;
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        self->drive[i].pulses[self->newest] = encoder_pulses(self, i);
    }
}

static void send_states(drive_node_t *self, int64_t ready_ns) {
    const int oldest = self->samples < VELOCITY_WINDOW ? 0 : (self->newest + 1) % VELOCITY_WINDOW;
    const double window_s = (double)(self->sample_ns[self->newest] - self->sample_ns[oldest]) / NS_PER_S;
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        const drive_t *drive = &self->drive[i];
        const double moved_pulses = drive->pulses[self->newest] - drive->pulses[oldest];
        const joint_state_t state = {
            .position_rad = (float)(drive->pulses[self->newest] / PULSES_PER_RAD),
            .velocity_radps = window_s > 0.0 ? (float)(moved_pulses / PULSES_PER_RAD / window_s) : 0.0f,
            .torque_Nm = (float)arm_plant_torque_Nm(self->plant, i),
            .mode = drive->mode,
            .error = self->timed_out ? DRIVE_ERROR_COMMAND_TIMEOUT : DRIVE_ERROR_NONE,
            .temperature_degC = TEMPERATURE_DEGC,
        };
        can_frame_t frame;
        if (joint_state_pack(i, &state, &frame) == PROTOCOL_OK) {
            endpoint_send(&self->endpoint, &frame, ready_ns);
        }
    }
}

static void on_command(void *context, frame_kind_t kind, const can_frame_t *message, int64_t end_ns) {
    drive_node_t *self = context;
    (void)kind;
    joint_cmd_t command;
    joint_cmd_unpack(message, &command);
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        self->drive[i].mode = self->enabled ? command.mode[i] : DRIVE_MODE_BRAKE;
        self->drive[i].commanded_radps = (double)command.velocity_radps[i];
    }
    self->commanded = true;
    self->timed_out = false;
    self->command_ns = end_ns;
    sample_encoders(self, end_ns);
    send_states(self, end_ns + DRIVE_RESPONSE_NS);
}

drive_node_t *drive_node_create(bus_t *bus, arm_plant_t *plant) {
    drive_node_t *self = calloc(1, sizeof *self);
    if (self != NULL) {
        self->plant = plant;
        self->enabled = true;
        self->timeout_ns = (int64_t)transport_timeout_ms(bus_profile(bus), FRAME_JOINT_CMD) * 1000000;
        self->period_ns = (int64_t)transport_period_ms(bus_profile(bus), FRAME_JOINT_STATE0) * 1000000;
        self->newest = VELOCITY_WINDOW - 1; /* so that the first sample gets index 0 */
        endpoint_attach(&self->endpoint, bus, ROBOT_JOINTS, ENDPOINT_KIND(FRAME_JOINT_CMD), on_command, self);
    }
    return self;
}

void drive_node_destroy(drive_node_t *self) {
    free(self);
}

void drive_node_enable(drive_node_t *self, bool enabled) {
    self->enabled = enabled;
}

void drive_node_step(drive_node_t *self, int64_t now_ns, double step_s) {
    self->timed_out = self->commanded && now_ns - self->command_ns > self->timeout_ns;
    if (self->timed_out && now_ns % self->period_ns == 0) {
        sample_encoders(self, now_ns);
        send_states(self, now_ns);
    }
    const double share = 1.0 - exp(-step_s / DRIVE_SERVO_TIME_CONSTANT_S);
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        drive_t *drive = &self->drive[i];
        if (self->timed_out || !self->enabled) {
            drive->mode = DRIVE_MODE_BRAKE;
        }
        if (drive->mode == DRIVE_MODE_VELOCITY) {
            drive->servo_radps += (drive->commanded_radps - drive->servo_radps) * share;
        } else {
            drive->servo_radps = 0.0;
        }
        arm_plant_set_velocity(self->plant, i, drive->servo_radps);
    }
}

double drive_node_encoder_rad(const drive_node_t *self, int joint) {
    return encoder_pulses(self, joint) / PULSES_PER_RAD;
}

uint32_t drive_node_rejected(const drive_node_t *self) {
    return endpoint_rejected(&self->endpoint);
}
