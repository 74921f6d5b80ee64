# Built for Cortex-M0+. It also runs on the board's Cortex-M0, which has the same instructions (ARMv6-M).
IMAGES += cortex-m0plus

cortex-m0plus.prefix := arm-none-eabi-
cortex-m0plus.specs := nano.specs
cortex-m0plus.cpu := -mcpu=cortex-m0plus -mthumb -mfloat-abi=soft
cortex-m0plus.folder := hal/nrf51
cortex-m0plus.script := hal/nrf51/nrf51.ld
cortex-m0plus.sources := hal/cortex_m/startup.c hal/cortex_m/stack_guard.c $(wildcard hal/nrf51/*.c) \
    $(COMMON_SOURCES) $(SLCAN_SOURCES)
cortex-m0plus.board := microbit
cortex-m0plus.emulator := qemu-system-arm -machine microbit
