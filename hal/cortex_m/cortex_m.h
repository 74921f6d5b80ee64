/* The registers of the Cortex-M cores that the ports use (ARM DDI 0403, 0419: chapter B3; ARM DDI 0553: chapter D1),
 * and the interrupt mask. */
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

/* One bit per interrupt, 32 interrupts per word. */
#define NVIC_SET_ENABLE(interrupt) REGISTER(0xE000E100u + (interrupt) / 32u * 4u)
#define NVIC_SET_PENDING(interrupt) REGISTER(0xE000E200u + (interrupt) / 32u * 4u)
#define NVIC_BIT(interrupt) (1u << (interrupt) % 32u)

#define SCB_INTERRUPT_STATE REGISTER(0xE000ED04u)
#define SCB_INTERRUPT_STATE_SYSTICK_PENDING (1u << 26)
#define SCB_HANDLER_CONTROL REGISTER(0xE000ED24u)
#define SCB_HANDLER_CONTROL_FAULTS (7u << 16) /* separate faults: memory management, bus, usage */
#define SCB_FAULT_STATUS REGISTER(0xE000ED28u)
#define SCB_FAULT_STATUS_STACK_OVERFLOW (1u << 20) /* ARMv8-M */
#define SCB_COPROCESSOR_ACCESS REGISTER(0xE000ED88u)
#define SCB_COPROCESSOR_ACCESS_FPU (0xFu << 20)

/* The memory protection unit of PMSAv7. */
#define MPU_CONTROL REGISTER(0xE000ED94u)
#define MPU_CONTROL_ENABLE (1u << 0)
#define MPU_CONTROL_DEFAULT_MAP (1u << 2) /* applies the default map to addresses outside all regions */
#define MPU_REGION_BASE REGISTER(0xE000ED9Cu)
#define MPU_REGION_BASE_VALID (1u << 4) /* the region's number is in bits 0..3 */
#define MPU_REGION_ATTRIBUTES REGISTER(0xE000EDA0u)
#define MPU_REGION_ENABLE (1u << 0)
#define MPU_REGION_SIZE(log2_bytes) (((log2_bytes) - 1u) << 1)
#define MPU_REGION_EXECUTE_NEVER (1u << 28) /* if all other attributes are 0, no access is allowed */

static inline void interrupts_off(void) {
    __asm__ volatile("cpsid i" ::: "memory");
}

static inline void interrupts_on(void) {
    __asm__ volatile("cpsie i" ::: "memory");
}

/* Sleeps until an interrupt is pending, even with interrupts off. */
static inline void wait_for_interrupt(void) {
    __asm__ volatile("dsb\n\twfi" ::: "memory");
}

#endif
