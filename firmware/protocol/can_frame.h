/* A data frame, CAN FD or classic, as the HAL sends and receives it. */
#ifndef COMANIP_CAN_FRAME_H
#define COMANIP_CAN_FRAME_H

#include <stdbool.h>
#include <stdint.h>

#define CAN_FRAME_MAX_BYTES 64

typedef struct {
    uint32_t timestamp_us; /* time of the frame's end on the bus, by the receiver's clock; unused when sending */
    uint16_t id;           /* 11 bits */
    uint8_t length;        /* number of data bytes: 0..8, 12, 16, 20, 24, 32, 48, 64 */
    bool fd;               /* true: CAN FD with bit-rate switch; false: classic, with length 0..8 */
    uint8_t data[CAN_FRAME_MAX_BYTES];
} can_frame_t;

/* Accepts frames in the order of the calls. The caller owns the frame. */
typedef struct {
    void (*send)(void *context, const can_frame_t *frame);
    void *context;
} can_sink_t;

#endif
