/* The thread has the process stack, lowest in RAM; exceptions have the main stack above it, and so can tell of a thread
 * that ran out of its own. What lies below faults: by the stack limit of ARMv8-M; by the MPU of ARMv7-M; on ARMv6-M,
 * which may have neither, because there is no memory. */
#include "cortex_m.h"
#include "drivers.h"

/* From the linker script. */
extern uint32_t link_thread_stack_end[];

/* A fault's frame is pushed on the thread's stack if it still fits. What pushes next would not have. */
#define LARGEST_PUSH_BYTES 128u

void stack_guard_start(void) {
#if defined(__ARM_ARCH_8M_MAIN__)
    __asm__ volatile("msr psplim, %0" ::"r"(link_thread_stack_end));
#elif defined(__ARM_ARCH_7M__) || defined(__ARM_ARCH_7EM__)
    enum { GUARD_LOG2_BYTES = 12 }; /* larger than any function's frame, which could jump over a small one */
    MPU_REGION_BASE = ((uint32_t)link_thread_stack_end - (1u << GUARD_LOG2_BYTES)) | MPU_REGION_BASE_VALID;
    MPU_REGION_ATTRIBUTES = MPU_REGION_EXECUTE_NEVER | MPU_REGION_SIZE(GUARD_LOG2_BYTES) | MPU_REGION_ENABLE;
    MPU_CONTROL = MPU_CONTROL_ENABLE | MPU_CONTROL_DEFAULT_MAP;
    __asm__ volatile("dsb\n\tisb" ::: "memory");
#endif
}

bool stack_overflowed(void) {
#if defined(__ARM_ARCH_8M_MAIN__)
    if ((SCB_FAULT_STATUS & SCB_FAULT_STATUS_STACK_OVERFLOW) != 0) {
        return true; /* the stack pointer still is what it was */
    }
#endif
    uint32_t thread_stack;
    __asm__ volatile("mrs %0, psp" : "=r"(thread_stack));
    return thread_stack < (uint32_t)link_thread_stack_end + LARGEST_PUSH_BYTES;
}
