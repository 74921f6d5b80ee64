/* A QEMU plugin that counts the instructions that an image executes between two addresses, and adds up their costs from
 * a table written by cycles.py.
 *
 * Arguments: begin=ADDRESS,end=ADDRESS,costs=FILE,out=FILE.
 * costs: the extra cost of a taken conditional branch, followed by the address (bit 0 is set for a conditional branch)
 * and the cost of each instruction, all of them 32-bit words.
 * out: the number of instructions and the total cost of each pass from begin to end.
 *
 * Debian ships QEMU without qemu-plugin.h, so the parts of its interface (version 1) that are used are declared
 * here. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))
#define INLINE_ADD_U64 0
#define CALLBACK_NO_REGISTERS 0

typedef uint64_t qemu_plugin_id_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
typedef void qemu_plugin_translated_t(qemu_plugin_id_t id, struct qemu_plugin_tb *block);
typedef void qemu_plugin_executed_t(unsigned int cpu, void *argument);

void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t id, qemu_plugin_translated_t *callback);
void qemu_plugin_register_vcpu_tb_exec_cb(struct qemu_plugin_tb *block, qemu_plugin_executed_t *callback, int flags,
                                          void *argument);
void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn *instruction, qemu_plugin_executed_t *callback,
                                            int flags, void *argument);
void qemu_plugin_register_vcpu_insn_exec_inline(struct qemu_plugin_insn *instruction, int operation, void *counter,
                                                uint64_t value);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *block);
struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *block, size_t index);
uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn *instruction);
size_t qemu_plugin_insn_size(const struct qemu_plugin_insn *instruction);

EXPORT extern const int qemu_plugin_version;
const int qemu_plugin_version = 1;
EXPORT int qemu_plugin_install(qemu_plugin_id_t id, const void *info, int argument_count, char **arguments);

typedef struct {
    uint32_t address, cost;
} cost_t;

/* A block of consecutively executed instructions. */
typedef struct {
    uint64_t begin, end;
    bool conditional; /* the last instruction is a conditional branch */
} block_t;

static uint64_t begin_address, end_address;
static cost_t *costs;
static size_t cost_count;
static uint64_t taken_cost;
static FILE *out;
static uint64_t instructions, cycles;
static uint64_t instructions_at_begin, cycles_at_begin;
static const block_t *last_block;

static const cost_t *cost_at(uint64_t address) {
    size_t low = 0, high = cost_count;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if ((costs[middle].address & ~1u) < address) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low < cost_count && (costs[low].address & ~1u) == address ? &costs[low] : NULL;
}

static void on_block(unsigned int cpu, void *argument) {
    (void)cpu;
    const block_t *block = argument;
    if (last_block != NULL && last_block->conditional && block->begin != last_block->end) {
        cycles += taken_cost;
    }
    last_block = block;
}

static void on_begin(unsigned int cpu, void *argument) {
    (void)cpu, (void)argument;
    instructions_at_begin = instructions;
    cycles_at_begin = cycles;
}

static void on_end(unsigned int cpu, void *argument) {
    (void)cpu, (void)argument;
    const uint32_t pair[2] = {(uint32_t)(instructions - instructions_at_begin), (uint32_t)(cycles - cycles_at_begin)};
    (void)fwrite(pair, sizeof pair, 1, out);
    (void)fflush(out);
}

static void on_translated(qemu_plugin_id_t id, struct qemu_plugin_tb *translated) {
    (void)id;
    const size_t count = qemu_plugin_tb_n_insns(translated);
    block_t *block = calloc(1, sizeof *block); /* never freed, because QEMU may execute the block at any time */
    for (size_t i = 0; i < count; i++) {
        struct qemu_plugin_insn *instruction = qemu_plugin_tb_get_insn(translated, i);
        const uint64_t address = qemu_plugin_insn_vaddr(instruction);
        const cost_t *cost = cost_at(address);
        if (i == 0) {
            block->begin = address;
        }
        block->end = address + qemu_plugin_insn_size(instruction);
        block->conditional = cost != NULL && (cost->address & 1u) != 0;
        qemu_plugin_register_vcpu_insn_exec_inline(instruction, INLINE_ADD_U64, &instructions, 1);
        qemu_plugin_register_vcpu_insn_exec_inline(instruction, INLINE_ADD_U64, &cycles, cost != NULL ? cost->cost : 0);
        if (address == begin_address || address == end_address) {
            qemu_plugin_register_vcpu_insn_exec_cb(instruction, address == begin_address ? on_begin : on_end,
                                                   CALLBACK_NO_REGISTERS, NULL);
        }
    }
    qemu_plugin_register_vcpu_tb_exec_cb(translated, on_block, CALLBACK_NO_REGISTERS, block);
}

static bool read_costs(const char *name) {
    FILE *file = fopen(name, "rb");
    uint32_t taken;
    if (file == NULL || fread(&taken, sizeof taken, 1, file) != 1) {
        return false;
    }
    taken_cost = taken;
    for (size_t space = 0;; cost_count++) {
        if (cost_count == space) {
            space = space == 0 ? 4096 : 2 * space;
            costs = realloc(costs, space * sizeof *costs);
        }
        if (fread(&costs[cost_count], sizeof *costs, 1, file) != 1) {
            return fclose(file) == 0;
        }
    }
}

int qemu_plugin_install(qemu_plugin_id_t id, const void *info, int argument_count, char **arguments) {
    (void)info;
    for (int i = 0; i < argument_count; i++) {
        char *value = strchr(arguments[i], '=');
        if (value == NULL) {
            return 1;
        }
        value++;
        if (strncmp(arguments[i], "begin=", 6) == 0) {
            begin_address = strtoull(value, NULL, 0);
        } else if (strncmp(arguments[i], "end=", 4) == 0) {
            end_address = strtoull(value, NULL, 0);
        } else if (strncmp(arguments[i], "costs=", 6) == 0 && !read_costs(value)) {
            return 1;
        } else if (strncmp(arguments[i], "out=", 4) == 0) {
            out = fopen(value, "wb");
        }
    }
    if (out == NULL || begin_address == 0 || end_address == 0) {
        return 1;
    }
    qemu_plugin_register_vcpu_tb_trans_cb(id, on_translated);
    return 0;
}
