/* The controller's state, and the frames that go in and out. */
#ifndef COMANIP_CONTROLLER_STATE_H
#define COMANIP_CONTROLLER_STATE_H

#include "control/arm_ik.h"
#include "control/cooperation.h"
#include "control/hand_motion.h"
#include "control/hand_tracker.h"
#include "control/joint_feedback.h"
#include "control/joint_limits.h"
#include "control/posture_change.h"
#include "control/supervisor.h"
#include "parameters/parameter_set.h"
#include "parameters/parameters.h"
#include "protocol/can_transport.h"
#include "protocol/port_status.h"

/* On CAN FD eight drives, tracker and operator send 13 frames in a tick; more wait for the next tick. */
#define CONTROLLER_INBOX_FRAMES 16
/* On classic CAN: JointCmd of 8 joints, TickTrace, status, heartbeat, and the identity, or two ParameterValue and
 * PortStatus. */
#define CONTROLLER_CYCLIC_FRAMES 19
/* An answer to each frame received, with a parameter's announcement before it; and the outcome of a save. */
#define CONTROLLER_OUTBOX_FRAMES (CONTROLLER_CYCLIC_FRAMES + 2 * CONTROLLER_INBOX_FRAMES + 1)

typedef struct {
    can_frame_t frame[CONTROLLER_INBOX_FRAMES];
    uint8_t count;
    bool save_over; /* the save that an outbox asked for is over, with this result */
    result_t save_result;
    port_status_t port; /* is published only: no decision depends on it, so that it need not be in TickTrace */
} controller_inbox_t;

typedef struct {
    can_sink_t sink; /* gets the tick's frames as they are made, at most CONTROLLER_OUTBOX_FRAMES */
    bool save;       /* start to save the parameters; not set again until an inbox reports that the save is over */
    /* The drives shall have power: while cooperating or holding, and until a stop, after a fault as well, has brought
     * the arm to rest. Set from the tick of the first JointCmd in velocity mode to the tick after the first one in
     * brake mode, so that the brakes close before the power goes. */
    bool enable_drives;
} controller_outbox_t;

typedef struct {
    const arm_ik_t *ik;
    const arm_t *arm; /* ik->arm */
    uint32_t tick_ms;

    parameters_t parameters;
    parameter_set_t parameter_set; /* the verdict on all of them together */
    /* derived from the parameters whenever one is written */
    differential_ik_config_t differential_ik_config;
    position_priority_config_t position_priority_config;
    joint_limits_config_t joint_limits_config;
    cooperation_config_t cooperation_config;
    bool predicts, changes_posture;
    pose_t marker_to_hand;
    bool marker_is_hand; /* marker_to_hand is the identity: its product is skipped */

    transport_receiver_t receiver;
    transport_sender_t sender;
    struct {
        frame_kind_t kind;
        uint8_t index;                  /* in the inbox */
    } request[CONTROLLER_INBOX_FRAMES]; /* the operator's, in this tick */
    uint8_t request_count;

    hand_tracker_t hand_tracker;
    hand_motion_t marker_motion; /* in the tracker frame */
    joint_feedback_t joints;
    pose_t hand;       /* the person's, in the tracker frame: now; with prediction, when the encoders were sampled */
    vector3_t lever_m; /* from the marker to the hand at that time; not kept up to date while the marker is the hand */

    supervisor_t supervisor;
    supervisor_inputs_t supervisor_inputs;
    bool finite; /* all numbers of the last tick were */

    task_id_t task_id; /* the selected task */
    task_t task;
    float blend_s;         /* how long it takes to come into force */
    float blend_elapsed_s; /* of that, while cooperating */
    cooperation_t cooperation;
    bool cooperation_changed; /* in this tick the operator started it, or changed its task, relation or reference */
    bool demand_deferred;     /* to the next tick, because of that change */
    float feedback_radps[ARM_MAX_JOINTS];    /* demanded for the pose error */
    float feedforward_radps[ARM_MAX_JOINTS]; /* demanded for the target's own motion; 0 without prediction */
    bool catching_up; /* the target was out of reach, or too fast, and the end effector has not reached it since */
    posture_change_t posture_change;
    joint_limits_t limits;
    bool moving; /* the last JointCmd was in velocity mode */

    uint32_t tick;
    uint16_t announced;   /* frames of the boot announcement sent so far */
    result_t boot_result; /* what it says of each parameter */
    bool saving;
    uint8_t save_parameter, save_sequence; /* of the request that started the save, for its answer */
    uint64_t unreported;                   /* bit mask of the parameters still to be reported to a refused request */
    uint8_t unreported_sequence;           /* that request's sequence number */
} controller_t;

/* The period of the controller's tick on this bus. */
static inline float controller_tick_s(const controller_t *self) {
    return 1e-3f * (float)self->tick_ms;
}

#endif
