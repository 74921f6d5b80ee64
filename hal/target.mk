# `make target`: the firmware as linked images for microcontrollers. Included by the Makefile, which defines BUILD,
# GENERATED, CORE_SOURCES (all but main.c) and CORE_CFLAGS.
#
# An image is a name in TARGET_IMAGES and NAME.{prefix,specs,cpu,script,sources}; see docs/porting.md.

TARGET_BUILD ?= $(BUILD)/target
TARGET_MAIN ?= firmware/main.c

TARGET_CFLAGS := $(CORE_CFLAGS) -g -ffunction-sections -fdata-sections -fcallgraph-info=su
TARGET_LDFLAGS := -nostartfiles -Wl,--gc-sections -Wl,--fatal-warnings
TARGET_SLCAN := $(filter-out hal/slcan/free_running.c hal/slcan/lockstep.c,$(wildcard hal/slcan/*.c))

CORTEX_M_IMAGES := cortex-m3 cortex-m4f cortex-m7
TARGET_IMAGES := $(CORTEX_M_IMAGES) rv32imac

cortex-m3.cpu := -mcpu=cortex-m3 -mthumb -mfloat-abi=soft
cortex-m4f.cpu := -mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard
cortex-m7.cpu := -mcpu=cortex-m7 -mthumb -mfpu=fpv5-sp-d16 -mfloat-abi=hard

# $(1): image. They differ in nothing but the core.
define CORTEX_M_VARIABLES
$(1).prefix := arm-none-eabi-
$(1).specs := nano.specs
$(1).script := hal/cortex_m/mps2.ld
$(1).sources := $(wildcard hal/cortex_m/*.c) $(TARGET_SLCAN) hal/slcan/free_running.c hal/no_store.c
endef
$(foreach image,$(CORTEX_M_IMAGES),$(eval $(call CORTEX_M_VARIABLES,$(image))))

rv32imac.prefix := riscv64-unknown-elf-
rv32imac.specs := picolibc.specs
rv32imac.cpu := -march=rv32imac -mabi=ilp32
rv32imac.script := hal/riscv/virt.ld
rv32imac.sources := $(wildcard hal/riscv/*.c) hal/riscv/startup.S $(TARGET_SLCAN) hal/slcan/free_running.c hal/no_store.c

# BOARD=, as QEMU calls its machines, and the image for it.
BOARDS := mps2-an385 mps2-an386 mps2-an500 virt
BOARD_IMAGE.mps2-an385 := cortex-m3
BOARD_IMAGE.mps2-an386 := cortex-m4f
BOARD_IMAGE.mps2-an500 := cortex-m7
BOARD_IMAGE.virt := rv32imac
BOARD_CHECK = @if [ -z "$(BOARD_IMAGE.$(BOARD))" ]; then echo "make $@: BOARD='$(BOARD)': expected one of $(BOARDS)" >&2; exit 2; fi

TARGET_PACKAGES := gcc-arm-none-eabi libnewlib-arm-none-eabi gcc-riscv64-unknown-elf picolibc-riscv64-unknown-elf \
    qemu-system-arm qemu-system-misc

.PHONY: target targets target-check target-deps pil bitexact size stack cycles

# All images, or the one for BOARD.
target: $(if $(BOARD),$(BOARD_IMAGE.$(BOARD):%=target-%),targets) ## the firmware as images in build/target/, and their sizes; BOARD=mps2-an386 etc.: one
	$(if $(BOARD),$(BOARD_CHECK))

# $(1): image
define IMAGE_RULES
$(1).compile := $$($(1).prefix)gcc --specs=$$($(1).specs) $$($(1).cpu)
$(1).objects := $$(addprefix $$(TARGET_BUILD)/$(1)/, \
    $$(addsuffix .o,$$(basename $$(CORE_SOURCES) $$($(1).sources) $$(TARGET_MAIN))))

$$(TARGET_BUILD)/$(1)/%.o: %.c hal/target.mk $$(GENERATED)/.generated | target-check
	@mkdir -p $$(@D)
	@echo "  CC [$(1)] $$<"
	$$(Q)$$($(1).compile) $$(TARGET_CFLAGS) -MMD -MP -c $$< -o $$@

$$(TARGET_BUILD)/$(1)/%.o: %.S hal/target.mk | target-check
	@mkdir -p $$(@D)
	@echo "  AS [$(1)] $$<"
	$$(Q)$$($(1).compile) -g -MMD -MP -c $$< -o $$@

$$(TARGET_BUILD)/$(1)/comanip.elf: $$($(1).objects) $$($(1).script)
	@echo "  LINK $$@"
	$$(Q)$$($(1).compile) $$(TARGET_CFLAGS) $$(TARGET_LDFLAGS) -T $$($(1).script) -Wl,-Map=$$(@:.elf=.map) \
	    $$($(1).objects) -lm -o $$@

-include $$($(1).objects:.o=.d)
endef

define TARGET_RULES
$(call IMAGE_RULES,$(1))
target-$(1): $$(TARGET_BUILD)/$(1)/comanip.elf
	@$$($(1).prefix)size $$<

.PHONY: target-$(1)
targets: target-$(1)
endef
$(foreach image,$(TARGET_IMAGES),$(eval $(call TARGET_RULES,$(image))))

# The same image in lockstep with the simulator (hal/slcan/lockstep.h): for `make pil`, not among TARGET_IMAGES.
define PIL_VARIABLES
$(1)-pil.prefix := $$($(1).prefix)
$(1)-pil.specs := $$($(1).specs)
$(1)-pil.cpu := $$($(1).cpu)
$(1)-pil.script := $$($(1).script)
$(1)-pil.sources := $$($(1).sources:hal/slcan/free_running.c=hal/slcan/lockstep.c)
endef
PIL_IMAGES := $(TARGET_IMAGES:%=%-pil)
$(foreach image,$(TARGET_IMAGES),$(eval $(call PIL_VARIABLES,$(image))))
$(foreach image,$(PIL_IMAGES),$(eval $(call IMAGE_RULES,$(image))))

PIL_PROCESS := $(BUILD)/host/comanip-pil
PIL_PROCESS_SOURCES := $(CORE_SOURCES) $(SIM_SOURCES) sim/bus/bus.c sim/programs/pil.c sim/programs/remote_firmware.c hal/slcan/slcan.c

$(PIL_PROCESS): $(PIL_PROCESS_SOURCES:%.c=$(BUILD)/host/%.o)
	@mkdir -p $(@D)
	@echo "  LINK $@"
	$(Q)$(CC) $^ -lode -lccd -lyaml -lm -o $@

pil: BOARD := $(or $(BOARD),mps2-an386)
pil: build target-check $(PIL_PROCESS) ## the image for BOARD=mps2-an386 etc. in QEMU, in lockstep with the simulator; takes what `make sim` takes
	$(BOARD_CHECK)
	@$(MAKE) --no-print-directory $(TARGET_BUILD)/$(BOARD_IMAGE.$(BOARD))-pil/comanip.elf
	@$(RUN_ARGUMENTS); \
	$(PYTHON) -m comanip.pil "$(BOARD)" $(TARGET_BUILD)/$(BOARD_IMAGE.$(BOARD))-pil/comanip.elf $(PIL_PROCESS) "$$@" $(ARGS)

size: deps targets ## what each module takes in each image, against hal/size_budget.toml; UPDATE=1 writes it anew; build/reports/size.json
	@$(PYTHON) -m comanip.size_report hal/size_budget.toml $(BUILD)/reports/size.json $(if $(UPDATE),--update) \
	    $(foreach image,$(TARGET_IMAGES),$(image)=$(TARGET_BUILD)/$(image)/comanip.map)

stack: deps targets ## the deepest that the stack of each image can get, against hal/stack_budget.toml; build/reports/stack.json
	@$(PYTHON) -m comanip.stack_report hal/stack_budget.toml $(BUILD)/reports/stack.json \
	    $(foreach image,$(TARGET_IMAGES),$(image)=$(TARGET_BUILD)/$(image))

bitexact: build target-check ## one input through every compiler's and processor's controller_step(): the same bytes; build/reports/bitexact.json
	@$(PYTHON) tests/bitexact/bitexact.py $(BUILD) $(if $(filter-out 0 no,$(SMOKE)),--smoke)

cycles: build target-check ## instructions and modelled cycles per tick, against hal/cycle_budget.toml; UPDATE=1 writes it anew; build/reports/cycles.json
	@$(PYTHON) tests/cycles/cycles.py $(BUILD) hal/cycle_budget.toml $(if $(UPDATE),--update)

# A compiler that does not find a specs file answers with its bare name.
target-check:
	@missing=; \
	$(foreach image,$(TARGET_IMAGES), \
	    command -v $($(image).prefix)gcc >/dev/null && \
	    test "$$($($(image).prefix)gcc -print-file-name=$($(image).specs))" != "$($(image).specs)" || \
	    missing="$$missing $($(image).prefix)gcc with $($(image).specs),";) \
	if [ -n "$$missing" ]; then \
	    echo "make target: not found:$${missing%,}. On Debian or Ubuntu: make target-deps, which installs" >&2; \
	    echo "  $(TARGET_PACKAGES)" >&2; \
	    exit 1; \
	fi

target-deps: ## install the cross compilers and QEMU (apt)
	@if ! command -v apt-get >/dev/null; then \
	    echo "make target-deps: no apt-get on this machine; install the equivalents of: $(TARGET_PACKAGES)" >&2; exit 1; \
	fi; \
	if [ "$$(id -u)" = 0 ]; then sudo=; \
	elif command -v sudo >/dev/null; then sudo=sudo; \
	else echo "make target-deps: needs root or sudo. Ask for: apt-get install $(TARGET_PACKAGES)" >&2; exit 1; \
	fi; \
	echo "comanip: installing $(TARGET_PACKAGES)"; \
	export DEBIAN_FRONTEND=noninteractive; \
	$$sudo apt-get update -qq && $$sudo apt-get install -y -qq --no-install-recommends $(TARGET_PACKAGES) >/dev/null
