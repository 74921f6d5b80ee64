/* The control and status registers of the RISC-V machine mode that the port uses (privileged specification 1.12,
 * chapter 3). */
#ifndef COMANIP_RISCV_H
#define COMANIP_RISCV_H

#include <stdint.h>

#define REGISTER(address) (*(volatile uint32_t *)(address))
#define BYTE_REGISTER(address) (*(volatile uint8_t *)(address))

#define MSTATUS_INTERRUPTS (1u << 3)
#define MIE_TIMER (1u << 7)
#define MIE_EXTERNAL (1u << 11)
#define MCAUSE_INTERRUPT (1u << 31)

/* Enables Zicsr for one instruction. The compiler's -march leaves Zicsr out, because no libc is built for
 * rv32imac_zicsr. */
#define CSR_ASM(instruction) ".option push\n\t.option arch, +zicsr\n\t" instruction "\n\t.option pop"

static inline void interrupts_off(void) {
    __asm__ volatile(CSR_ASM("csrc mstatus, %0")::"r"(MSTATUS_INTERRUPTS) : "memory");
}

static inline void interrupts_on(void) {
    __asm__ volatile(CSR_ASM("csrs mstatus, %0")::"r"(MSTATUS_INTERRUPTS) : "memory");
}

static inline void interrupts_enable(uint32_t mie) {
    __asm__ volatile(CSR_ASM("csrs mie, %0")::"r"(mie) : "memory");
}

/* Sleeps until an interrupt is pending. Also wakes up if interrupts are off. */
static inline void wait_for_interrupt(void) {
    __asm__ volatile("wfi" ::: "memory");
}

#endif
