/* The rings between thread and interrupt. The producer of a ring publishes elements by storing the head, and the
 * consumer frees elements by storing the tail. */
#include "slcan_link.h"

static uint16_t after(uint16_t index, uint16_t size) {
    return (uint16_t)(index + 1u == size ? 0u : index + 1u);
}

bool slcan_link_receive(slcan_link_t *self, can_frame_t *frame) {
    uint16_t tail = atomic_load_explicit(&self->rx_tail, memory_order_relaxed);
    if (tail == atomic_load_explicit(&self->rx_head, memory_order_acquire)) {
        return false;
    }
    *frame = self->rx[tail];
    atomic_store_explicit(&self->rx_tail, after(tail, SLCAN_LINK_RX_FRAMES), memory_order_release);
    return true;
}

bool slcan_link_send(slcan_link_t *self, const can_frame_t *frame) {
    char line[SLCAN_LINE_MAX_BYTES];
    size_t length = slcan_encode(frame, line);
    uint16_t head = atomic_load_explicit(&self->tx_head, memory_order_relaxed);
    uint16_t tail = atomic_load_explicit(&self->tx_tail, memory_order_acquire);
    unsigned room = (tail + SLCAN_LINK_TX_BYTES - head - 1u) % SLCAN_LINK_TX_BYTES;
    if (length == 0 || length > room) {
        self->counters.tx_dropped++;
        return false;
    }
    for (size_t i = 0; i < length; i++) {
        self->tx[head] = (uint8_t)line[i];
        head = after(head, SLCAN_LINK_TX_BYTES);
    }
    atomic_store_explicit(&self->tx_head, head, memory_order_release);
    return true;
}

void slcan_link_put_byte(slcan_link_t *self, uint8_t byte, uint32_t now_us) {
    uint16_t head = atomic_load_explicit(&self->rx_head, memory_order_relaxed);
    can_frame_t *frame = &self->rx[head]; /* always free, so that lines can be decoded into it */
    switch (slcan_decode(&self->decoder, byte, frame)) {
    case SLCAN_FRAME:
        if (after(head, SLCAN_LINK_RX_FRAMES) == atomic_load_explicit(&self->rx_tail, memory_order_acquire)) {
            self->counters.rx_overflow++;
            break;
        }
        frame->timestamp_us = now_us;
        atomic_store_explicit(&self->rx_head, after(head, SLCAN_LINK_RX_FRAMES), memory_order_release);
        break;
    case SLCAN_MALFORMED: self->counters.rx_malformed++; break;
    case SLCAN_PENDING:
    case SLCAN_IGNORED: break;
    }
}

void slcan_link_overrun(slcan_link_t *self) {
    self->counters.rx_overrun++;
    slcan_spoil(&self->decoder);
}

bool slcan_link_take_byte(slcan_link_t *self, uint8_t *byte) {
    uint16_t tail = atomic_load_explicit(&self->tx_tail, memory_order_relaxed);
    if (tail == atomic_load_explicit(&self->tx_head, memory_order_acquire)) {
        return false;
    }
    *byte = self->tx[tail];
    atomic_store_explicit(&self->tx_tail, after(tail, SLCAN_LINK_TX_BYTES), memory_order_release);
    return true;
}
