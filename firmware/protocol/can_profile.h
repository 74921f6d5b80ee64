/* What the bus can carry, chosen at start or when the image is built. */
#ifndef COMANIP_CAN_PROFILE_H
#define COMANIP_CAN_PROFILE_H

typedef enum {
    CAN_PROFILE_FD = 0,      /* CAN FD, 1/5 Mbit/s: control at 1 kHz, a message is one frame, E2E Profile 5 */
    CAN_PROFILE_CLASSIC = 1, /* 1 Mbit/s: control at 250 Hz, long messages in parts, E2E Profile 2 */
} can_profile_t;

/* The profile that was asked for; in an image that is built for one alone, with -DCAN_FD_ONLY or -DCAN_CLASSIC_ONLY,
 * that one: the compiler then leaves out the other's code. */
static inline can_profile_t can_profile_in_force(can_profile_t asked) {
#if defined CAN_FD_ONLY
    (void)asked;
    return CAN_PROFILE_FD;
#elif defined CAN_CLASSIC_ONLY
    (void)asked;
    return CAN_PROFILE_CLASSIC;
#else
    return asked;
#endif
}

#endif
