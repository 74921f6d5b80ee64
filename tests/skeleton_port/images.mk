IMAGES += skeleton

skeleton.prefix := arm-none-eabi-
skeleton.specs := nano.specs
skeleton.cpu := -mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard
skeleton.folder := hal/skeleton
skeleton.script := hal/skeleton/skeleton.ld
skeleton.sources := $(wildcard hal/cortex_m/*.c hal/skeleton/*.c) $(COMMON_SOURCES)
skeleton.board := skeleton
skeleton.emulator := qemu-system-arm -machine mps2-an386 -semihosting-config enable=on,target=native
