/* A serial line that takes the role of a CAN controller, with bounded rings between the firmware's thread and the
 * UART's interrupt. Each ring has one producer and one consumer on the same core, so plain atomic indices are
 * enough. */
#ifndef COMANIP_SLCAN_LINK_H
#define COMANIP_SLCAN_LINK_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "slcan.h"

/* Sizes of the rings; one element of each ring always stays free. In a millisecond, eight drives, the tracker and the
 * operator together send up to 13 frames, and the firmware usually sends lines of 288 bytes in total. */
#define SLCAN_LINK_RX_FRAMES 16u
#define SLCAN_LINK_TX_BYTES 1024u

/* Counts every loss. Each counter is written only by the thread or only by the interrupt. */
typedef struct {
    uint32_t rx_malformed; /* malformed lines */
    uint32_t rx_overflow;  /* received frames lost because the ring was full */
    uint32_t rx_overrun;   /* number of times that the UART lost bytes */
    uint32_t tx_dropped;   /* frames not sent, because the ring was full or SLCAN cannot represent them */
} slcan_link_counters_t;

/* Zero-initialise. */
typedef struct {
    slcan_decoder_t decoder;
    can_frame_t rx[SLCAN_LINK_RX_FRAMES];
    _Atomic uint16_t rx_head; /* index of the next element to write */
    _Atomic uint16_t rx_tail; /* index of the next element to read */
    uint8_t tx[SLCAN_LINK_TX_BYTES];
    _Atomic uint16_t tx_head;
    _Atomic uint16_t tx_tail;
    slcan_link_counters_t counters;
} slcan_link_t;

/* For the thread: returns the next received frame, or false if there is none. */
bool slcan_link_receive(slcan_link_t *self, can_frame_t *frame);

/* For the thread: queues a frame's line, completely or not at all. */
bool slcan_link_send(slcan_link_t *self, const can_frame_t *frame);

/* For the interrupt: takes a received byte. now_us: time of reception of the frame, if this byte completes a frame. */
void slcan_link_put_byte(slcan_link_t *self, uint8_t byte, uint32_t now_us);

/* For the interrupt: reports that the UART has lost bytes. */
void slcan_link_overrun(slcan_link_t *self);

/* For the interrupt: returns the next byte to send, or false if there is none. */
bool slcan_link_take_byte(slcan_link_t *self, uint8_t *byte);

#endif
