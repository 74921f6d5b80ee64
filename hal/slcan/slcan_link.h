/* A serial line in the role of a CAN controller: bounded rings between the firmware's thread and the UART's interrupt.
 * Each ring has one producer and one consumer on one core, so that plain atomic indices are enough. */
#ifndef COMANIP_SLCAN_LINK_H
#define COMANIP_SLCAN_LINK_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "slcan.h"

/* One element of each ring stays free. Eight drives, tracker and operator send 13 frames in a millisecond. A tick
 * usually sends 288 bytes. */
#define SLCAN_LINK_RX_FRAMES 16u
#define SLCAN_LINK_TX_BYTES 1024u

/* Every loss is counted. Each counter has one writer. */
typedef struct {
    uint32_t rx_malformed; /* lines */
    uint32_t rx_overflow;  /* frames that found the ring full */
    uint32_t rx_overrun;   /* times that the UART lost bytes */
    uint32_t tx_dropped;   /* frames that found the ring full, or that a line cannot carry */
} slcan_link_counters_t;

/* Zero-initialise. */
typedef struct {
    slcan_decoder_t decoder;
    can_frame_t rx[SLCAN_LINK_RX_FRAMES];
    _Atomic uint16_t rx_head; /* next to write */
    _Atomic uint16_t rx_tail; /* next to read */
    uint8_t tx[SLCAN_LINK_TX_BYTES];
    _Atomic uint16_t tx_head;
    _Atomic uint16_t tx_tail;
    slcan_link_counters_t counters;
} slcan_link_t;

/* Thread: the next received frame. False: there is none. */
bool slcan_link_receive(slcan_link_t *self, can_frame_t *frame);

/* Thread: queues a frame's line, whole or not at all. */
bool slcan_link_send(slcan_link_t *self, const can_frame_t *frame);

/* Interrupt: one byte came in. now_us: the frame's time of reception if the byte ends one. */
void slcan_link_put_byte(slcan_link_t *self, uint8_t byte, uint32_t now_us);

/* Interrupt: the UART lost bytes. */
void slcan_link_overrun(slcan_link_t *self);

/* Interrupt: the next byte to send. False: none. */
bool slcan_link_take_byte(slcan_link_t *self, uint8_t *byte);

#endif
