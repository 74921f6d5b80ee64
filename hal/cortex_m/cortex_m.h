/* Registers of the ARMv7-M core that the port uses (ARM DDI 0403, chapter B3), and its interrupt mask. */
#ifndef COMANIP_CORTEX_M_H
#define COMANIP_CORTEX_M_H

#include <stdint.h>

#define REGISTER(address) (*(volatile uint32_t *)(address))

#define SYSTICK_CONTROL REGISTER(0xE000E010u)
#define SYSTICK_CONTROL_ENABLE (1u << 0)
#define SYSTICK_CONTROL_INTERRUPT (1u << 1)
#define SYSTICK_CONTROL_CORE_CLOCK (1u << 2)
#define SYSTICK_RELOAD REGISTER(0xE000E014u)
#define SYSTICK_VALUE REGISTER(0xE000E018u)

#define NVIC_SET_ENABLE REGISTER(0xE000E100u)  /* interrupts 0..31 */
#define NVIC_SET_PENDING REGISTER(0xE000E200u)

#define SCB_INTERRUPT_STATE REGISTER(0xE000ED04u)
#define SCB_INTERRUPT_STATE_SYSTICK_PENDING (1u << 26)
#define SCB_HANDLER_CONTROL REGISTER(0xE000ED24u)
#define SCB_HANDLER_CONTROL_FAULTS (7u << 16) /* memory management, bus and usage faults apart from the hard fault */
#define SCB_COPROCESSOR_ACCESS REGISTER(0xE000ED88u)
#define SCB_COPROCESSOR_ACCESS_FPU (0xFu << 20)

static inline void interrupts_off(void) {
    __asm__ volatile("cpsid i" ::: "memory");
}

static inline void interrupts_on(void) {
    __asm__ volatile("cpsie i" ::: "memory");
}

/* Returns when an interrupt is pending, even while they are off. */
static inline void wait_for_interrupt(void) {
    __asm__ volatile("dsb\n\twfi" ::: "memory");
}

#endif
