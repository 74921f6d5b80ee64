IMAGES += rv32imac rv32imafc

rv32imac.cpu := -march=rv32imac -mabi=ilp32
rv32imac.board := virt
rv32imac.emulator := qemu-system-riscv32 -machine virt -bios none
rv32imafc.cpu := -march=rv32imafc -mabi=ilp32f
rv32imafc.board := virt-rv32imafc
rv32imafc.emulator := qemu-system-riscv32 -machine virt -bios none

define VIRT_IMAGE
$(1).prefix := riscv64-unknown-elf-
$(1).specs := picolibc.specs
$(1).folder := hal/riscv_virt
$(1).script := hal/riscv_virt/virt.ld
$(1).sources := $(wildcard hal/riscv_virt/*.c) hal/riscv_virt/startup.S $(COMMON_SOURCES) $(SLCAN_SOURCES)
endef
$(foreach image,rv32imac rv32imafc,$(eval $(call VIRT_IMAGE,$(image))))
