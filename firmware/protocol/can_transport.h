/* Sends and receives messages in either profile. A message is a frame of can_protocol.h in its CAN FD layout. On
 * classic CAN, it is split into the frames of can_classic.h, which are reassembled only if their counters are equal and
 * they arrive within the message's timeout. A message therefore never mixes parts of two samples. */
#ifndef COMANIP_CAN_TRANSPORT_H
#define COMANIP_CAN_TRANSPORT_H

#include "can_classic.h"
#include "can_profile.h"
#include "can_protocol.h"

#define TRANSPORT_MAX_FRAMES 8 /* largest number of frames of a message, CLASSIC_MAX_PARTS */
#define TRANSPORT_ALL_KINDS ((UINT32_C(1) << FRAME_KIND_COUNT) - 1u)

typedef struct {
    can_profile_t profile;
    uint8_t joint_count; /* number of the arm's joints; on classic CAN, JointCmd has one part per joint */
    protocol_sender_t counters;
} transport_sender_t;

void transport_sender_init(transport_sender_t *self, can_profile_t profile, uint8_t joint_count);

/* Adds end-to-end protection to the message, in place, and sends its frames, at most TRANSPORT_MAX_FRAMES. Returns
 * false, and sends nothing, if classic CAN cannot carry one of the message's values. */
bool transport_send(transport_sender_t *self, can_frame_t *message, const can_sink_t *sink);

typedef struct {
    uint8_t counter;
    uint8_t received;  /* bit mask of the parts received so far; 0: none */
    uint32_t begun_us; /* reception time of the first part */
    uint8_t part[CLASSIC_MAX_PARTS][CLASSIC_MAX_BYTES];
} transport_pending_t;

#ifdef CAN_FD_ONLY
#define TRANSPORT_MULTIPART_KINDS 1 /* no kind has several parts on CAN FD, but C does not allow empty arrays */
#else
#define TRANSPORT_MULTIPART_KINDS COMANIP_MULTIPART_COUNT /* number of kinds with several parts on classic CAN */
#endif

typedef struct {
    can_profile_t profile;
    uint8_t joint_count;
    uint32_t kinds;               /* bit mask of the frame_kind_t values that are received */
    protocol_receiver_t protocol; /* on classic CAN, holds the counters of the last complete messages */
    e2e_receiver_t classic[CLASSIC_FRAME_COUNT];
    transport_pending_t pending[TRANSPORT_MULTIPART_KINDS];
    uint32_t pose_stamp_us, pose_received_us; /* times of the last valid HandPose on classic CAN */
} transport_receiver_t;

/* kinds: mask such as (1 << FRAME_...) | ..., or TRANSPORT_ALL_KINDS. */
void transport_receiver_init(transport_receiver_t *self, can_profile_t profile, uint8_t joint_count, uint32_t kinds);

/* Checks a received frame. If it completes a message, replaces *frame by the message, with the reception time of its
 * last part, and returns PROTOCOL_OK. Refused frames are counted as in protocol_check(). Returns PROTOCOL_UNKNOWN_ID
 * for frames of kinds that are not in `kinds`. */
protocol_status_t transport_receive(transport_receiver_t *self, can_frame_t *frame, frame_kind_t *kind);

/* Returns the id of the message's first frame. */
uint16_t transport_first_id(can_profile_t profile, frame_kind_t kind);

/* Return a message's period and timeout in this profile: see frame_description_t. JointCmd's period is the control
 * period. */
uint16_t transport_period_ms(can_profile_t profile, frame_kind_t kind);
uint16_t transport_timeout_ms(can_profile_t profile, frame_kind_t kind);

/* Returns the largest coordinate of a hand's position that this profile can carry; a pose beyond it is sent as
 * invalid. */
float transport_hand_range_m(can_profile_t profile);

/* Returns true if a message is the same frame in both profiles, that is, it has at most 8 bytes and no classic CAN
 * frames of its own. */
bool transport_is_same_frame(frame_kind_t kind);

/* Writes the ids of the frames that the firmware receives, for the filters of a CAN controller, and returns their
 * number. */
#define TRANSPORT_MAX_IDS (CLASSIC_FRAME_COUNT + FRAME_KIND_COUNT)
uint8_t transport_ids_to_firmware(can_profile_t profile, uint16_t ids[TRANSPORT_MAX_IDS]);

#endif
