# Three boards that differ only in the core.
IMAGES += cortex-m3 cortex-m4f cortex-m7

cortex-m3.cpu := -mcpu=cortex-m3 -mthumb -mfloat-abi=soft
cortex-m3.board := mps2-an385
cortex-m4f.cpu := -mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard
cortex-m4f.board := mps2-an386
cortex-m7.cpu := -mcpu=cortex-m7 -mthumb -mfpu=fpv5-sp-d16 -mfloat-abi=hard
cortex-m7.board := mps2-an500

define MPS2_IMAGE
$(1).prefix := arm-none-eabi-
$(1).specs := nano.specs
$(1).folder := hal/mps2
$(1).script := hal/mps2/mps2.ld
$(1).sources := $(wildcard hal/cortex_m/*.c hal/mps2/*.c) $(COMMON_SOURCES) $(SLCAN_SOURCES)
$(1).emulator := qemu-system-arm -machine $($(1).board)
endef
$(foreach image,cortex-m3 cortex-m4f cortex-m7,$(eval $(call MPS2_IMAGE,$(image))))
