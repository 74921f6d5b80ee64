/* The messages of can_protocol.h in the classic CAN frames Classic* of comanip.dbc: short ones in one frame, long ones
 * in parts, which have consecutive places in classic_table. Translates raw integers into raw integers, so that all
 * targets compute the same bits; end-to-end protection and the parts' equal counters are can_transport.h's.
 *
 * What is coarser than on CAN FD: positions of hands and targets have 0.1 mm and reach 3.2767 m, rotations have 15 bits
 * for each of the three smaller components (within 0.009 deg), torques 0.2 Nm up to 25.4 Nm; drives do not report
 * their temperature. */
#ifndef COMANIP_CAN_CLASSIC_H
#define COMANIP_CAN_CLASSIC_H

#include "can_protocol.h"
#include "comanip_schema.h"

#define CLASSIC_MAX_BYTES 8
#define CLASSIC_MAX_PARTS 8 /* JointCmd: one for each joint */

#define CLASSIC_FRAME_NAME(name, id, bytes, data_id, period_ms, timeout_ms, to_firmware) name,
typedef enum { COMANIP_CLASSIC_FRAMES(CLASSIC_FRAME_NAME) CLASSIC_FRAME_COUNT } classic_frame_t;

extern const frame_description_t classic_table[CLASSIC_FRAME_COUNT];

/* The message's first frame, its number of parts on the bus of an arm with so many joints. FirmwareHeartbeat, which is
 * the same in both profiles, has 0 parts. */
classic_frame_t classic_first(frame_kind_t kind);
uint8_t classic_parts(frame_kind_t kind, uint8_t joint_count);

/* The inverse. False: no frame of classic_table has this id. */
bool classic_find(uint16_t id, classic_frame_t *frame, frame_kind_t *kind);

/* message: data of the CAN FD frame. part: of all parts, without end-to-end protection. False, and the parts are not to
 * be sent: a value does not fit. A HandPose that does not fit becomes an invalid one, and a target of TickTrace none.
 */
bool classic_split(frame_kind_t kind, const uint8_t message[CAN_FRAME_MAX_BYTES],
                   uint8_t part[CLASSIC_MAX_PARTS][CLASSIC_MAX_BYTES]);

/* part: JointCmd's of joints that the arm does not have are zeros. message: data of the CAN FD frame, without
 * end-to-end protection. The t_us of a HandPose is modulo CLASSIC_STAMP_PERIOD_US, in steps of CLASSIC_STAMP_STEP_US.
 */
void classic_join(frame_kind_t kind, uint8_t part[CLASSIC_MAX_PARTS][CLASSIC_MAX_BYTES],
                  uint8_t message[CAN_FRAME_MAX_BYTES]);

#define CLASSIC_STAMP_STEP_US 1024u
#define CLASSIC_STAMP_PERIOD_US (256u * CLASSIC_STAMP_STEP_US)

/* The stamp with all its bits that is the nearest to the expected one: within half a CLASSIC_STAMP_PERIOD_US. Written
 * into the data of a joined HandPose. */
uint32_t classic_unwrap_stamp(uint8_t message[CAN_FRAME_MAX_BYTES], uint32_t expected_us);

#endif
