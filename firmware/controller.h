/* One tick of the firmware: frames in, frames out.
 *
 *   decode -> hand -> Algorithm 1 + task -> control law -> limits -> encode, watched by the supervisor
 *
 * On CAN FD a tick is 1 ms, on classic CAN 4 ms.
 *
 * A pure function of the state, the time, the frames received and how a saving ended: the same log gives the same bytes
 * on every target. */
#ifndef COMANIP_CONTROLLER_H
#define COMANIP_CONTROLLER_H

#include "control/cooperation.h"
#include "control/differential_ik.h"
#include "control/hand_motion.h"
#include "control/hand_tracker.h"
#include "control/joint_feedback.h"
#include "control/joint_limits.h"
#include "control/posture_change.h"
#include "control/supervisor.h"
#include "parameters/parameter_set.h"
#include "parameters/parameters.h"
#include "protocol/can_transport.h"

#define CONTROLLER_INBOX_FRAMES                                                                                        \
    16 /* CAN FD: eight drives, tracker and operator send 13 a tick; more wait for the next */
#define CONTROLLER_CYCLIC_FRAMES                                                                                       \
    17 /* on classic CAN: JointCmd of 8 joints, TickTrace, status, heartbeat; identity, or two ParameterValue */
/* An answer to each frame, with the announcement of a parameter before it; and that a saving is over. */
#define CONTROLLER_OUTBOX_FRAMES (CONTROLLER_CYCLIC_FRAMES + 2 * CONTROLLER_INBOX_FRAMES + 1)

typedef struct {
    can_frame_t frame[CONTROLLER_INBOX_FRAMES];
    uint8_t count;
    bool save_over; /* the saving that an outbox had asked for is over: with this result */
    result_t save_result;
} controller_inbox_t;

typedef struct {
    can_sink_t sink; /* gets the tick's frames as they are made, at most CONTROLLER_OUTBOX_FRAMES */
    bool save;       /* the parameters shall be saved; until an inbox says that it is over, this is not asked again */
} controller_outbox_t;

typedef struct {
    const arm_t *arm;
    parameters_t parameters;
    parameter_set_t parameter_set;                   /* what they are together */
    differential_ik_config_t differential_ik_config; /* views of the parameters, made anew when one is written */
    position_priority_config_t position_priority_config;
    joint_limits_config_t joint_limits_config;
    cooperation_config_t cooperation_config;
    bool predicts, changes_posture;
    pose_t marker_to_hand;
    bool marker_is_hand; /* marker_to_hand is the identity, and need not be computed with */

    transport_receiver_t receiver;
    transport_sender_t sender;
    uint32_t tick_ms;
    struct {
        frame_kind_t kind;
        uint8_t index;                  /* in the inbox */
    } request[CONTROLLER_INBOX_FRAMES]; /* this tick's operator frames */
    uint8_t request_count;

    hand_tracker_t hand_tracker;
    hand_motion_t marker_motion; /* in the tracker frame */
    joint_feedback_t joints;
    pose_t hand; /* human's hand in the tracker frame, this tick; with prediction, when the encoders were sampled */
    vector3_t lever_m; /* with prediction: from the marker to the hand, then; where the marker is the hand, not kept */

    supervisor_t supervisor;
    supervisor_inputs_t supervisor_inputs;

    task_id_t task_id; /* selected */
    task_t task;
    float blend_s;         /* how long the selected task takes to come into force */
    float blend_elapsed_s; /* of it, in the law's ticks */
    cooperation_t cooperation;
    bool cooperation_changed; /* by the operator, in this tick: started, its task or relation, its reference */
    bool demand_deferred;     /* in this tick, for that */
    float feedback_radps[ARM_MAX_JOINTS];    /* the law's, for the error */
    float feedforward_radps[ARM_MAX_JOINTS]; /* the law's, for the target's own motion: 0 without prediction */
    bool catching_up;                        /* the target was out of reach, or too fast, and has not been met since */
    posture_change_t posture_change;
    joint_limits_t limits;
    bool finite; /* the last tick's numbers were */

    uint32_t tick;
    uint16_t announced;   /* frames of the boot announcement sent so far */
    result_t boot_result; /* as it tells it of each parameter */
    bool saving;
    uint8_t save_parameter, save_sequence; /* of the request, for its answer */
    uint64_t unreported;         /* parameters, a bit each, still to be named to whoever was refused for them */
    uint8_t unreported_sequence; /* of that request */
} controller_t;

/* The arm table must outlive the controller. */
void controller_init(controller_t *self, const arm_t *arm, can_profile_t profile);

/* Before the first step: parameters in place of the defaults. result: what the boot announcement says of them,
 * RESULT_ACCEPTED or, when a record was not valid, RESULT_STORE_FAILED. */
void controller_set_parameters(controller_t *self, const parameters_t *parameters, result_t result);

/* now_us: monotonic modulo 2^32, one tick after the last call. inbox: the frames received since then, oldest first, and
 * afterwards the messages that they were. A frame stamped after now_us, as one that came while the inbox was filled,
 * counts as received at now_us. outbox: its sink gets the frames to send, in that order; `save` is set. */
void controller_step(controller_t *self, uint32_t now_us, controller_inbox_t *inbox, controller_outbox_t *outbox);

#endif
