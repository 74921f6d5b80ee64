/* The kind of bus, chosen at start-up or when the image is built. */
#ifndef COMANIP_CAN_PROFILE_H
#define COMANIP_CAN_PROFILE_H

typedef enum {
    CAN_PROFILE_FD = 0,      /* CAN FD, 1/5 Mbit/s: control at 1 kHz, one frame per message, E2E Profile 5 */
    CAN_PROFILE_CLASSIC = 1, /* classic CAN, 1 Mbit/s: control at 250 Hz, long messages in parts, E2E Profile 2 */
} can_profile_t;

/* Returns the requested profile. In an image built with -DCAN_FD_ONLY or -DCAN_CLASSIC_ONLY, always returns the only
 * supported profile, so that the compiler omits the code of the other one. */
static inline can_profile_t can_profile_in_force(can_profile_t requested) {
#if defined CAN_FD_ONLY
    (void)requested;
    return CAN_PROFILE_FD;
#elif defined CAN_CLASSIC_ONLY
    (void)requested;
    return CAN_PROFILE_CLASSIC;
#else
    return requested;
#endif
}

#endif
