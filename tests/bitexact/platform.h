/* Input and output of the runner: the files input.bin and output.bin in the working directory of the runner or, for an
 * image, of the emulator. An image accesses these files through semihosting, by which a program in an emulator can use
 * the host's files (ARM IHI 0100; RISC-V uses the same calls). */
#ifndef COMANIP_BITEXACT_PLATFORM_H
#define COMANIP_BITEXACT_PLATFORM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define INPUT_NAME "input.bin"
#define OUTPUT_NAME "output.bin"

#if defined(__arm__) || defined(__riscv)

#define SEMIHOSTING_OPEN 0x01u
#define SEMIHOSTING_WRITE 0x05u
#define SEMIHOSTING_READ 0x06u
#define SEMIHOSTING_CLOSE 0x02u
#define SEMIHOSTING_EXIT 0x18u
#define EXIT_REASON 0x20026u /* ADP_Stopped_ApplicationExit */
#define MODE_READ 1u         /* "rb" */
#define MODE_WRITE 5u        /* "wb" */
#define BUFFER_BYTES 512u

typedef struct {
    uintptr_t file;
    uint8_t bytes[BUFFER_BYTES];
    size_t count, used;
} platform_buffer_t;

static platform_buffer_t platform_input, platform_output;

static inline uintptr_t semihosting(uintptr_t operation, const void *argument) {
#if defined(__arm__)
    register uintptr_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
#else
    register uintptr_t a0 __asm__("a0") = operation;
    register const void *a1 __asm__("a1") = argument;
    __asm__ volatile(".balign 16\n.option push\n.option norvc\nslli x0, x0, 0x1f\nebreak\nsrai x0, x0, 7\n.option pop"
                     : "+r"(a0)
                     : "r"(a1)
                     : "memory");
    return a0;
#endif
}

static inline uintptr_t semihosting3(uintptr_t operation, uintptr_t a, uintptr_t b, uintptr_t c) {
    const uintptr_t arguments[3] = {a, b, c};
    return semihosting(operation, arguments);
}

static inline void platform_open(void) {
    platform_input.file = semihosting3(SEMIHOSTING_OPEN, (uintptr_t)INPUT_NAME, MODE_READ, sizeof INPUT_NAME - 1);
    platform_output.file = semihosting3(SEMIHOSTING_OPEN, (uintptr_t)OUTPUT_NAME, MODE_WRITE, sizeof OUTPUT_NAME - 1);
}

/* Reads `count` bytes. Returns false at the end of the input. */
static inline bool platform_read(void *bytes, size_t count) {
    platform_buffer_t *in = &platform_input;
    for (size_t i = 0; i < count; i++) {
        if (in->used == in->count) {
            const size_t missing = semihosting3(SEMIHOSTING_READ, in->file, (uintptr_t)in->bytes, BUFFER_BYTES);
            in->count = BUFFER_BYTES - missing;
            in->used = 0;
            if (in->count == 0) {
                return false;
            }
        }
        ((uint8_t *)bytes)[i] = in->bytes[in->used++];
    }
    return true;
}

static inline void platform_flush(void) {
    (void)semihosting3(SEMIHOSTING_WRITE, platform_output.file, (uintptr_t)platform_output.bytes,
                       platform_output.count);
    platform_output.count = 0;
}

static inline void platform_write(const uint8_t bytes[], size_t count) {
    if (platform_output.count + count > BUFFER_BYTES) {
        platform_flush();
    }
    memcpy(&platform_output.bytes[platform_output.count], bytes, count);
    platform_output.count += count;
}

static inline void platform_close(void) {
    platform_flush();
    (void)semihosting(SEMIHOSTING_CLOSE, &platform_output.file);
    (void)semihosting(SEMIHOSTING_EXIT, (const void *)(uintptr_t)EXIT_REASON);
}

#else

#include <stdio.h>
#include <stdlib.h>

static FILE *platform_input, *platform_output;

static inline void platform_open(void) {
    platform_input = fopen(INPUT_NAME, "rb");
    platform_output = fopen(OUTPUT_NAME, "wb");
    if (platform_input == NULL || platform_output == NULL) {
        exit(EXIT_FAILURE);
    }
}

static inline bool platform_read(void *bytes, size_t count) {
    return fread(bytes, 1, count, platform_input) == count;
}

static inline void platform_write(const uint8_t bytes[], size_t count) {
    (void)fwrite(bytes, 1, count, platform_output);
}

static inline void platform_close(void) {
    (void)fclose(platform_input);
    if (fclose(platform_output) != 0) {
        exit(EXIT_FAILURE);
    }
}

int main(void) {
    firmware_main();
    return EXIT_SUCCESS;
}

#endif

#endif
