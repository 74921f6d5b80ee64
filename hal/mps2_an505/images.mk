IMAGES += cortex-m33

cortex-m33.prefix := arm-none-eabi-
cortex-m33.specs := nano.specs
cortex-m33.cpu := -mcpu=cortex-m33 -mthumb -mfpu=fpv5-sp-d16 -mfloat-abi=hard
cortex-m33.folder := hal/mps2_an505
cortex-m33.script := hal/mps2_an505/an505.ld
cortex-m33.sources := $(wildcard hal/cortex_m/*.c hal/mps2/*.c) $(COMMON_SOURCES) $(SLCAN_SOURCES)
cortex-m33.board := mps2-an505
cortex-m33.emulator := qemu-system-arm -machine mps2-an505
