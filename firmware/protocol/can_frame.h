/* A data frame, CAN FD or classic, as it is passed through the HAL. */
#ifndef COMANIP_CAN_FRAME_H
#define COMANIP_CAN_FRAME_H

#include <stdbool.h>
#include <stdint.h>

#define CAN_FRAME_MAX_BYTES 64

typedef struct {
    uint32_t timestamp_us; /* end of the frame on the bus, receiver's clock; unused when sending */
    uint16_t id;           /* 11 bits */
    uint8_t length;        /* bytes: 0..8, 12, 16, 20, 24, 32, 48, 64 */
    bool fd;               /* CAN FD with bit-rate switch; else classic, and length is 0..8 */
    uint8_t data[CAN_FRAME_MAX_BYTES];
} can_frame_t;

/* Receives frames in the order of the calls. The caller owns the frame. */
typedef struct {
    void (*send)(void *context, const can_frame_t *frame);
    void *context;
} can_sink_t;

#endif
