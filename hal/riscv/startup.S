/* Reset: trap vector, stack and memory, then the firmware. Runs on hart 0; others sleep. */
    .option arch, +zicsr
    .section .text.start, "ax", @progbits
    .globl reset_handler
    .type reset_handler, @function
reset_handler:
    csrw mie, zero
    csrr t0, mhartid
    bnez t0, sleep
    la t0, trap_handler
    csrw mtvec, t0
    .option push
    .option norelax
    la gp, __global_pointer$
    .option pop
    la sp, link_stack_top

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

    .section .rodata.loop_ended, "a", @progbits
loop_ended:
    .string "the firmware's loop ended"
