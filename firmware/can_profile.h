/* What the bus can carry, chosen at start. */
#ifndef COMANIP_CAN_PROFILE_H
#define COMANIP_CAN_PROFILE_H

typedef enum {
    CAN_PROFILE_FD = 0,      /* CAN FD, 1/5 Mbit/s: control at 1 kHz, a message is one frame, E2E Profile 5 */
    CAN_PROFILE_CLASSIC = 1, /* 1 Mbit/s: control at 250 Hz, long messages in parts, E2E Profile 2 */
} can_profile_t;

#endif
