/* The reset handler sets up trap vector, stacks and memory, and then runs the firmware. It uses hart 0; the other harts
 * sleep. This file also contains the trap entry. Traps have their own stack, and can therefore report that the
 * thread has overflowed its stack. */
    .option arch, +zicsr
    .equ MSTATUS_FLOATING_POINT, 1 << 13 /* initial */
    .equ PMP_LOCKED_NAPOT, 0x98          /* no access, not even in machine mode */
    .equ STACK_GUARD_BYTES, 4096         /* larger than any function's frame, which could jump over a smaller guard */

    .section .text.start, "ax", @progbits
    .globl reset_handler
    .type reset_handler, @function
reset_handler:
    csrw mie, zero
    csrr t0, mhartid
    bnez t0, sleep
    la t0, trap_entry
    csrw mtvec, t0
    la t0, link_trap_stack_top
    csrw mscratch, t0 /* holds the trap's stack pointer while the thread runs, and the thread's during a trap */
#ifdef __riscv_flen
    li t0, MSTATUS_FLOATING_POINT
    csrs mstatus, t0
#endif

    /* An access below the thread's stack causes a fault, by PMP (privileged specification 1.12, chapter 3.7). */
    la t0, link_thread_stack_end - STACK_GUARD_BYTES
    srli t0, t0, 2
    ori t0, t0, (STACK_GUARD_BYTES >> 3) - 1
    csrw pmpaddr0, t0
    li t0, PMP_LOCKED_NAPOT
    csrw pmpcfg0, t0
    .option push
    .option norelax
    la gp, __global_pointer$
    .option pop
    la sp, link_thread_stack_top

    la t0, link_data_image
    la t1, link_data_start
    la t2, link_data_end
copy_data:
    bgeu t1, t2, data_copied
    lw t3, 0(t0)
    sw t3, 0(t1)
    addi t0, t0, 4
    addi t1, t1, 4
    j copy_data
data_copied:

    la t1, link_bss_start
    la t2, link_bss_end
clear_bss:
    bgeu t1, t2, bss_cleared
    sw zero, 0(t1)
    addi t1, t1, 4
    j clear_bss
bss_cleared:

    call firmware_main
    la a0, loop_ended
    tail hal_panic

sleep:
    wfi
    j sleep
    .size reset_handler, . - reset_handler

    .section .text.trap_entry, "ax", @progbits
#ifdef __riscv_flen
    .equ FRAME_BYTES, 4 * (16 + 20)
#else
    .equ FRAME_BYTES, 4 * 16
#endif
/* Stores or loads the registers that a call may overwrite. operation, float_operation: the store or load instruction
 * for integer and floating-point registers. */
    .macro caller_saved operation, float_operation
    .set slot, 0
    .irp name, ra, t0, t1, t2, t3, t4, t5, t6, a0, a1, a2, a3, a4, a5, a6, a7
    \operation \name, 4 * slot(sp)
    .set slot, slot + 1
    .endr
#ifdef __riscv_flen
    .irp name, ft0, ft1, ft2, ft3, ft4, ft5, ft6, ft7, ft8, ft9, ft10, ft11, fa0, fa1, fa2, fa3, fa4, fa5, fa6, fa7
    \float_operation \name, 4 * slot(sp)
    .set slot, slot + 1
    .endr
#endif
    .endm

    .balign 4 /* the low bits of mtvec hold its mode */
    .type trap_entry, @function
trap_entry:
    csrrw sp, mscratch, sp
    addi sp, sp, -FRAME_BYTES
    caller_saved sw, fsw
    csrr a0, mcause
    csrr a1, mscratch
    call trap_handler
    caller_saved lw, flw
    addi sp, sp, FRAME_BYTES
    csrrw sp, mscratch, sp
    mret
    .size trap_entry, . - trap_entry

    .section .rodata.loop_ended, "a", @progbits
loop_ended:
    .string "the firmware's loop ended"
