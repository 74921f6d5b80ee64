/* QEMU's "virt" machine: constants for the drivers. */
#ifndef COMANIP_BOARD_H
#define COMANIP_BOARD_H

#include "riscv.h"

#define BOARD_CLINT_BASE 0x02000000u
#define BOARD_TIMER_HZ 10000000u /* mtime */

#define BOARD_PLIC_BASE 0x0C000000u

#define BOARD_UART_BASE 0x10000000u /* 16550, registers one byte apart */
#define BOARD_UART_INTERRUPT 10u    /* its number at the PLIC */

#endif
