/* Ends the emulator through semihosting (ARM IHI 0100). */
#ifndef COMANIP_SKELETON_SEMIHOSTING_H
#define COMANIP_SKELETON_SEMIHOSTING_H

#include <stdbool.h>
#include <stdint.h>

#define SEMIHOSTING_EXIT 0x18u
#define EXIT_SUCCESS_REASON 0x20026u
#define EXIT_FAILURE_REASON 0x20023u

static inline void semihosting_exit(bool is_success) {
    register uint32_t r0 __asm__("r0") = SEMIHOSTING_EXIT;
    register uint32_t r1 __asm__("r1") = is_success ? EXIT_SUCCESS_REASON : EXIT_FAILURE_REASON;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
}

#endif
