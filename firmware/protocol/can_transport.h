/* Messages over the bus, in either profile: a message is a frame of can_protocol.h, in the layout that it has on CAN
 * FD. On classic CAN it goes in the frames of can_classic.h, which are put together again only if their counters are
 * equal and they came within one timeout: no message is ever torn. */
#ifndef COMANIP_CAN_TRANSPORT_H
#define COMANIP_CAN_TRANSPORT_H

#include "can_classic.h"
#include "can_profile.h"
#include "can_protocol.h"

#define TRANSPORT_MAX_FRAMES 8 /* of one message: CLASSIC_MAX_PARTS */
#define TRANSPORT_ALL_KINDS ((UINT32_C(1) << FRAME_KIND_COUNT) - 1u)

typedef struct {
    can_profile_t profile;
    uint8_t joint_count; /* of the arm: so many parts has its JointCmd on classic CAN */
    protocol_sender_t counters;
} transport_sender_t;

void transport_sender_init(transport_sender_t *self, can_profile_t profile, uint8_t joint_count);

/* Protects the message, in place, and sends its frames, at most TRANSPORT_MAX_FRAMES. False: nothing was sent, classic
 * CAN cannot carry a value of it. */
bool transport_send(transport_sender_t *self, can_frame_t *message, const can_sink_t *sink);

typedef struct {
    uint8_t counter;
    uint8_t received;  /* parts, one bit each; 0: none is waiting */
    uint32_t begun_us; /* reception of the first of them */
    uint8_t part[CLASSIC_MAX_PARTS][CLASSIC_MAX_BYTES];
} transport_pending_t;

#ifdef CAN_FD_ONLY
#define TRANSPORT_MULTIPART_KINDS 1 /* none, but C has no empty arrays */
#else
#define TRANSPORT_MULTIPART_KINDS COMANIP_MULTIPART_COUNT /* that have several parts on classic CAN */
#endif

typedef struct {
    can_profile_t profile;
    uint8_t joint_count;
    uint32_t kinds;               /* that are listened to, one bit for each frame_kind_t */
    protocol_receiver_t protocol; /* classic CAN: counters of the last whole messages */
    e2e_receiver_t classic[CLASSIC_FRAME_COUNT];
    transport_pending_t pending[TRANSPORT_MULTIPART_KINDS];
    uint32_t pose_stamp_us, pose_received_us; /* of the last valid HandPose on classic CAN */
} transport_receiver_t;

/* kinds: (1 << FRAME_...) | ..., or TRANSPORT_ALL_KINDS. */
void transport_receiver_init(transport_receiver_t *self, can_profile_t profile, uint8_t joint_count, uint32_t kinds);

/* PROTOCOL_OK: *frame has become the message, received when its last part was. Refusals are counted as in
 * protocol_check(); frames of other kinds than those listened to are PROTOCOL_UNKNOWN_ID. */
protocol_status_t transport_receive(transport_receiver_t *self, can_frame_t *frame, frame_kind_t *kind);

/* The message's only frame, or its first. */
uint16_t transport_first_id(can_profile_t profile, frame_kind_t kind);

/* Of a message, in this profile: as frame_description_t. JointCmd's period is the firmware's tick. */
uint16_t transport_period_ms(can_profile_t profile, frame_kind_t kind);
uint16_t transport_timeout_ms(can_profile_t profile, frame_kind_t kind);

/* A hand's position is sent as invalid beyond +- this much. */
float transport_hand_range_m(can_profile_t profile);

/* Ids of the frames that the firmware receives, for the filters of a CAN controller. Returns their number. */
#define TRANSPORT_MAX_IDS CLASSIC_FRAME_COUNT
uint8_t transport_ids_to_firmware(can_profile_t profile, uint16_t ids[TRANSPORT_MAX_IDS]);

#endif
