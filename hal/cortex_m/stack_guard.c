/* The thread uses the process stack, at the lowest addresses of RAM. Exceptions use the main stack above it, and can
 * therefore report that the thread has overflowed its stack. An access below the process stack causes a fault. On
 * ARMv8-M, the stack limit register triggers it; on ARMv7-M, the MPU does. ARMv6-M may have neither; the access then
 * causes a fault because there is no memory at those addresses. */
#include "cortex_m.h"
#include "drivers.h"

/* Defined by the linker script. */
extern uint32_t link_thread_stack_end[];

/* On a fault, the exception frame is pushed onto the thread's stack if it still fits. After an overflow, the stack
 * therefore has less room left than the largest push needs. */
#define LARGEST_PUSH_BYTES 128u

void stack_guard_start(void) {
#if defined(__ARM_ARCH_8M_MAIN__)
    __asm__ volatile("msr psplim, %0" ::"r"(link_thread_stack_end));
#elif defined(__ARM_ARCH_7M__) || defined(__ARM_ARCH_7EM__)
    enum { GUARD_LOG2_BYTES = 12 }; /* larger than any stack frame, because a larger frame could jump over the guard */
    MPU_REGION_BASE = ((uint32_t)link_thread_stack_end - (1u << GUARD_LOG2_BYTES)) | MPU_REGION_BASE_VALID;
    MPU_REGION_ATTRIBUTES = MPU_REGION_EXECUTE_NEVER | MPU_REGION_SIZE(GUARD_LOG2_BYTES) | MPU_REGION_ENABLE;
    MPU_CONTROL = MPU_CONTROL_ENABLE | MPU_CONTROL_DEFAULT_MAP;
    __asm__ volatile("dsb\n\tisb" ::: "memory");
#endif
}

bool stack_overflowed(void) {
#if defined(__ARM_ARCH_8M_MAIN__)
    if ((SCB_FAULT_STATUS & SCB_FAULT_STATUS_STACK_OVERFLOW) != 0) {
        return true; /* the stack pointer was left unchanged, so the check below would miss the overflow */
    }
#endif
    uint32_t thread_stack;
    __asm__ volatile("mrs %0, psp" : "=r"(thread_stack));
    return thread_stack < (uint32_t)link_thread_stack_end + LARGEST_PUSH_BYTES;
}
