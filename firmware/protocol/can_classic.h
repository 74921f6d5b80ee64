/* Splits CAN FD messages into the classic CAN frames Classic* of comanip.dbc, and joins them again. A short message
 * fits in one frame; a long one has several parts, which are at consecutive indices of classic_table. Only raw integers
 * are converted, so all targets compute the same bits. can_transport.h adds end-to-end protection, with equal counters
 * in all parts of a message.
 *
 * The resolution is lower than on CAN FD. Positions have steps of 0.1 mm and a range of +-3.2767 m. Rotations have 15
 * bits for each of the three smaller quaternion components, and an error of at most 0.009 deg. Torques have steps of
 * 0.2 Nm and a range of +-25.4 Nm. Drives do not report their temperature. */
#ifndef COMANIP_CAN_CLASSIC_H
#define COMANIP_CAN_CLASSIC_H

#include "can_protocol.h"
#include "comanip_schema.h"

#define CLASSIC_MAX_BYTES 8
#define CLASSIC_MAX_PARTS 8 /* JointCmd has one part for each joint */

#define CLASSIC_FRAME_NAME(name, id, bytes, data_id, period_ms, timeout_ms, to_firmware) name,
typedef enum { COMANIP_CLASSIC_FRAMES(CLASSIC_FRAME_NAME) CLASSIC_FRAME_COUNT } classic_frame_t;

extern const frame_description_t classic_table[CLASSIC_FRAME_COUNT];

/* Return the index of the message's first part in classic_table, and the number of its parts for an arm with
 * joint_count joints. A message that is the same in both profiles, such as FirmwareHeartbeat, has 0 parts. */
classic_frame_t classic_first(frame_kind_t kind);
uint8_t classic_parts(frame_kind_t kind, uint8_t joint_count);

/* Finds the part with this id, and its message. Returns false if no frame of classic_table has this id. */
bool classic_find(uint16_t id, classic_frame_t *frame, frame_kind_t *kind);

/* Splits a message into its parts. message: data of the CAN FD frame. part: data of all parts, without end-to-end
 * protection. Returns false if a value does not fit; the parts must then not be sent. The exceptions are a HandPose
 * and the target in a TickTrace, which are marked invalid instead. */
bool classic_split(frame_kind_t kind, const uint8_t message[CAN_FRAME_MAX_BYTES],
                   uint8_t part[CLASSIC_MAX_PARTS][CLASSIC_MAX_BYTES]);

/* Joins the parts into a message. part: data of all parts; zeros for joints that the arm does not have. message: data
 * of the CAN FD frame, without end-to-end protection. A HandPose's t_us is modulo CLASSIC_STAMP_PERIOD_US and has a
 * resolution of CLASSIC_STAMP_STEP_US. */
void classic_join(frame_kind_t kind, uint8_t part[CLASSIC_MAX_PARTS][CLASSIC_MAX_BYTES],
                  uint8_t message[CAN_FRAME_MAX_BYTES]);

#define CLASSIC_STAMP_STEP_US 1024u
#define CLASSIC_STAMP_PERIOD_US (256u * CLASSIC_STAMP_STEP_US)

/* Extends the timestamp of a joined HandPose to 32 bits, in place, and returns it. Chooses the candidate closest to
 * expected_us, so the result differs from expected_us by at most half of CLASSIC_STAMP_PERIOD_US. */
uint32_t classic_unwrap_stamp(uint8_t message[CAN_FRAME_MAX_BYTES], uint32_t expected_us);

#endif
