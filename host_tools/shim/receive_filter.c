/* Compiles the filters of a raw CAN socket to classic BPF: see receive_filter.h. */
#include "receive_filter.h"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <sys/socket.h>

#define INSTRUCTIONS_PER_FILTER 4
#define INSTRUCTIONS_BESIDE 16
#define ACCEPT 0xFFFFu
#define REJECT 0u

typedef struct {
    struct sock_filter code[CAN_RAW_FILTER_MAX * INSTRUCTIONS_PER_FILTER + INSTRUCTIONS_BESIDE];
    unsigned short length;
} program_t;

static void emit(program_t *self, unsigned code, unsigned char if_true, unsigned char if_false, uint32_t value) {
    self->code[self->length++] = (struct sock_filter){(unsigned short)code, if_true, if_false, value};
}

/* Loads the id and masks it. The mask is converted, because BPF loads in network byte order, whereas the id is in host
 * byte order. */
static void emit_masked_id(program_t *self, uint32_t mask) {
    emit(self, BPF_LD | BPF_W | BPF_ABS, 0, 0, 0);
    emit(self, BPF_ALU | BPF_AND | BPF_K, 0, 0, htonl(mask));
}

static void emit_return(program_t *self, uint32_t verdict) {
    emit(self, BPF_RET | BPF_K, 0, 0, verdict);
}

/* Emits code that returns the verdict for ids that match the filter or, if when_matching is false, for ids that do
 * not. */
static void emit_filter(program_t *self, const struct can_filter *filter, bool when_matching, uint32_t verdict) {
    const bool is_inverted = (filter->can_id & CAN_INV_FILTER) != 0;
    uint32_t mask = filter->can_mask & ~CAN_ERR_FLAG;
    if ((mask & CAN_EFF_FLAG) != 0 && (filter->can_id & CAN_EFF_FLAG) == 0) {
        mask &= CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG; /* 11 bits of id; the kernel applies the same mask */
    }
    const bool ends_if_equal = is_inverted != when_matching;
    emit_masked_id(self, mask);
    emit(self, BPF_JMP | BPF_JEQ | BPF_K, ends_if_equal ? 0 : 1, ends_if_equal ? 1 : 0, htonl(filter->can_id & mask));
    emit_return(self, verdict);
}

void receive_filter_init(receive_filter_t *self) {
    *self = (receive_filter_t){.count = 1};
}

int receive_filter_attach(const receive_filter_t *self, int fd) {
    program_t program = {.length = 0};
    if (!self->fd_frames) {
        emit(&program, BPF_LD | BPF_W | BPF_LEN, 0, 0, 0);
        emit(&program, BPF_JMP | BPF_JEQ | BPF_K, 1, 0, CAN_MTU);
        emit_return(&program, REJECT);
    }
    emit_masked_id(&program, CAN_ERR_FLAG);
    emit(&program, BPF_JMP | BPF_JEQ | BPF_K, 5, 0, 0); /* data frames: jump to the filters */
    emit_masked_id(&program, self->errors & CAN_ERR_MASK);
    emit(&program, BPF_JMP | BPF_JEQ | BPF_K, 1, 0, 0);
    emit_return(&program, ACCEPT);
    emit_return(&program, REJECT);
    const bool join = self->join && self->count > 0;
    for (int i = 0; i < self->count; i++) {
        emit_filter(&program, &self->filter[i], !join, join ? REJECT : ACCEPT);
    }
    emit_return(&program, join ? ACCEPT : REJECT);
    const struct sock_fprog attached = {.len = program.length, .filter = program.code};
    return setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &attached, sizeof attached);
}
