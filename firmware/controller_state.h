/* The controller's state, and its inbox and outbox of frames. */
#ifndef COMANIP_CONTROLLER_STATE_H
#define COMANIP_CONTROLLER_STATE_H

#include "control/arm_ik.h"
#include "control/cooperation.h"
#include "control/hand_motion.h"
#include "control/hand_tracker.h"
#include "control/joint_limits.h"
#include "control/posture_change.h"
#include "control/supervisor.h"
#include "parameters/parameter_set.h"
#include "parameters/parameters.h"
#include "protocol/can_transport.h"
#include "protocol/port_status.h"
#include "safety/joint_watch.h"

/* On CAN FD, usually at most 13 frames arrive in a tick: 8 JointState, HandPose, TrackerStatus, and one request of each
 * of 3 kinds. Frames beyond 16 wait for the next tick. */
#define CONTROLLER_INBOX_FRAMES 16
/* Upper bound of the number of cyclic frames in a tick, for classic CAN, which needs the most frames: JointCmd of 8
 * joints (8 frames), TickTrace (5), status (1), heartbeat (1), and either the identity (3), or two ParameterValue (2)
 * and PortStatus (2). */
#define CONTROLLER_CYCLIC_FRAMES 19
/* Maximum number of frames sent in a tick: the cyclic frames; for each received frame, an answer preceded by the
 * announcement of a parameter; and the outcome of a save. */
#define CONTROLLER_OUTBOX_FRAMES (CONTROLLER_CYCLIC_FRAMES + 2 * CONTROLLER_INBOX_FRAMES + 1)

typedef struct {
    can_frame_t frame[CONTROLLER_INBOX_FRAMES];
    uint8_t count;
    bool save_over; /* the last requested save, if any, has ended with save_result */
    result_t save_result;
    port_status_t port; /* published but never used in a decision, so TickTrace need not record it */
} controller_inbox_t;

typedef struct {
    can_sink_t sink; /* receives the tick's frames in order, at most CONTROLLER_OUTBOX_FRAMES */
    bool save;       /* request to save the parameters; not set again until an inbox reports that the save has ended */
    /* Enables the drives' power while the arm cooperates or holds, and until it has come to rest after a stop or a
     * fault. It is true from the tick of the first JointCmd in velocity mode until the tick after the first JointCmd in
     * brake mode, so that the brakes engage before the power is switched off. */
    bool enable_drives;
} controller_outbox_t;

typedef struct {
    const arm_ik_t *ik;
    const arm_t *arm; /* ik->arm */
    uint32_t tick_ms;

    parameters_t parameters;
    parameter_set_t parameter_set; /* stability of the parameters as a set */
    /* derived from the parameters whenever one of them is written: */
    differential_ik_config_t differential_ik_config;
    position_priority_config_t position_priority_config;
    joint_limits_config_t joint_limits_config;
    cooperation_config_t cooperation_config;
    bool predicts, changes_posture;
    pose_t marker_to_hand;
    bool marker_is_hand; /* marker_to_hand is the identity, so multiplying by it is skipped */

    transport_receiver_t receiver;
    transport_sender_t sender;
    struct {
        frame_kind_t kind;
        uint8_t index;                  /* index in the inbox */
    } request[CONTROLLER_INBOX_FRAMES]; /* the operator's requests in this tick */
    uint8_t request_count;

    hand_tracker_t hand_tracker;
    hand_motion_t marker_motion;        /* in the tracker frame */
    float measured_rad[ARM_MAX_JOINTS]; /* the joints' positions, as the drives last reported them */
    joint_watch_t joint_watch;
    /* The pose of the person's hand in the tracker frame: with prediction, at the time when the encoders were sampled;
     * without prediction, at present. */
    pose_t hand;
    /* The lever from the marker to the hand at the same time, in tracker axes. It is 0 without prediction, and is not
     * updated while marker_is_hand. */
    vector3_t lever_m;

    supervisor_t supervisor;
    supervisor_inputs_t supervisor_inputs;
    bool finite; /* all numbers computed in the last tick were finite */

    task_id_t task_id; /* the selected task */
    task_t task;
    float blend_s;         /* time over which the selected task replaces the previous one */
    float blend_elapsed_s; /* elapsed part of blend_s; advances only while cooperating */
    cooperation_t cooperation;
    bool cooperation_changed;                /* in this tick, the operator started or changed the cooperation */
    bool demand_deferred;                    /* because of such a change, this tick computes no new demand */
    float feedback_radps[ARM_MAX_JOINTS];    /* velocities that correct the pose error */
    float feedforward_radps[ARM_MAX_JOINTS]; /* velocities that follow the target's own motion; 0 without prediction */
    bool catching_up; /* the target was out of reach or too fast, and the end effector has not caught up yet */
    posture_change_t posture_change;
    joint_limits_t limits;
    bool moving; /* the last JointCmd was in velocity mode */

    uint32_t tick;
    uint16_t announced;   /* number of boot announcement frames sent so far */
    result_t boot_result; /* result to report with each parameter in the announcement */
    bool saving;
    uint8_t save_parameter, save_sequence; /* from the request that started the save; repeated in its answer */
    uint64_t unreported;                   /* bit mask of the parameters yet to be reported after a refused request */
    uint8_t unreported_sequence;           /* sequence number of that request */
} controller_t;

/* Returns the tick period on this bus. */
static inline float controller_tick_s(const controller_t *self) {
    return 1e-3f * (float)self->tick_ms;
}

#endif
