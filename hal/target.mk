# `make target` links the firmware to images for microcontrollers. Included by the Makefile, which defines BUILD,
# GENERATED, CORE_SOURCES (all except main.c) and CORE_CFLAGS.
#
# An image is defined by a name in IMAGES and the variables NAME.{board,prefix,specs,cpu,folder,script,sources,emulator}
# in its port's images.mk: see docs/porting.md.

# PROFILE= selects the kind of CAN that the images support: fd, classic, or both (the board then selects one at reset).
# Without classic CAN, the images are a quarter smaller.
TARGET_PROFILES := fd classic both
TARGET_PROFILE := $(or $(PROFILE),fd)
PROFILE_CFLAGS := $(if $(filter fd,$(TARGET_PROFILE)),-DCAN_FD_ONLY) \
    $(if $(filter classic,$(TARGET_PROFILE)),-DCAN_CLASSIC_ONLY)
TARGET_BUILD ?= $(BUILD)/target$(addprefix -,$(filter-out fd,$(TARGET_PROFILE)))
TARGET_MAIN ?= firmware/main.c

TARGET_CFLAGS := $(CORE_CFLAGS) $(PROFILE_CFLAGS) -g -ffunction-sections -fdata-sections -fcallgraph-info=su
TARGET_LDFLAGS := -nostartfiles -Wl,--gc-sections -Wl,--fatal-warnings

# Sources that ports share: first the tick loop and the stubs for a missing parameter store, then CAN over a UART.
COMMON_SOURCES := hal/common/tick.c hal/common/no_store.c
SLCAN_SOURCES := $(wildcard hal/slcan/*.c)

IMAGES :=
include $(sort $(wildcard hal/*/images.mk))
MAKEFILES_READ := Makefile hal/target.mk $(wildcard hal/*/images.mk) # they contain the compilers' options

# BOARD= is the name of a QEMU machine, or the name given in the port's images.mk.
BOARDS := $(foreach image,$(IMAGES),$($(image).board))
BOARD_IMAGE = $(strip $(foreach image,$(IMAGES),$(if $(filter $(image) $($(image).board),$(BOARD)),$(image))))
BOARD_CHECK = @if [ "$(words $(BOARD_IMAGE))" != 1 ] || [ "$(words $(BOARD))" != 1 ]; then \
    echo "make $(@:-check=): BOARD='$(BOARD)': expected one of $(BOARDS), or an image: $(IMAGES)" >&2; exit 2; fi
# For targets that cover all images and do not accept BOARD=. $(1): the profiles for which their figures are valid.
ALL_IMAGES_CHECK = @if [ -n "$(BOARD)" ]; then \
    echo "make $(@:-check=): BOARD='$(BOARD)': expected none: make $(@:-check=) covers all images" >&2; exit 2; fi; \
    case ' $(1) ' in *' $(TARGET_PROFILE) '*) ;; *) \
    echo "make $(@:-check=): PROFILE='$(PROFILE)': expected one of: $(1)" >&2; exit 2;; esac

TARGET_PACKAGES := gcc-arm-none-eabi libnewlib-arm-none-eabi gcc-riscv64-unknown-elf picolibc-riscv64-unknown-elf \
    qemu-system-arm qemu-system-misc

.PHONY: images target targets target-check target-deps pil pil-check pil-matrix pil-matrix-check bitexact \
    bitexact-check size size-check stack stack-check cycles cycles-check

# All images, or only the one for BOARD.
target: $(if $(BOARD),$(BOARD_IMAGE:%=target-%),targets)
target: ## build all images in build/target/, or BOARD=mps2-an386 etc.; PROFILE=fd|classic|both
	$(if $(BOARD),$(BOARD_CHECK))

# $(1): image
define IMAGE_RULES
$(1).compile := $$($(1).prefix)gcc --specs=$$($(1).specs) $$($(1).cpu) -I$$($(1).folder)
$(1).objects := $$(addprefix $$(TARGET_BUILD)/$(1)/, \
    $$(addsuffix .o,$$(basename $$(CORE_SOURCES) $$($(1).sources) $$(TARGET_MAIN))))

$$(TARGET_BUILD)/$(1)/%.o: %.c $$(MAKEFILES_READ) $$(GENERATED)/.generated | target-check
	@mkdir -p $$(@D)
	@echo "  CC [$(1)] $$<"
	$$(Q)$$($(1).compile) $$(TARGET_CFLAGS) -MMD -MP -c $$< -o $$@

$$(TARGET_BUILD)/$(1)/%.o: %.S $$(MAKEFILES_READ) | target-check
	@mkdir -p $$(@D)
	@echo "  AS [$(1)] $$<"
	$$(Q)$$($(1).compile) -g -MMD -MP -c $$< -o $$@

$$(TARGET_BUILD)/$(1)/comanip.elf: $$($(1).objects) $$(wildcard hal/*/*.ld)
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
$(foreach image,$(IMAGES),$(eval $(call TARGET_RULES,$(image))))

# The same images, in lockstep with the simulator (hal/lockstep/lockstep.h), for ports with CAN over a UART. They are
# built by `make pil` and are not listed in IMAGES.
define PIL_VARIABLES
$(foreach variable,prefix specs cpu folder script,$(eval $(1)-pil.$(variable) := $($(1).$(variable))))
$(1)-pil.sources := $$(filter-out $(LOCKSTEP_REPLACES),$$($(1).sources)) hal/lockstep/lockstep.c
endef
LOCKSTEP_REPLACES := hal/common/tick.c hal/slcan/slcan_receive.c
SLCAN_IMAGES := $(foreach image,$(IMAGES),$(if $(filter hal/slcan/slcan_receive.c,$($(image).sources)),$(image)))
PIL_IMAGES := $(SLCAN_IMAGES:%=%-pil)
$(foreach image,$(SLCAN_IMAGES),$(eval $(call PIL_VARIABLES,$(image))))
$(foreach image,$(PIL_IMAGES),$(eval $(call IMAGE_RULES,$(image))))

PIL_PROCESS := $(BUILD)/host/comanip-pil
PIL_PROCESS_SOURCES := $(CORE_SOURCES) $(SIM_SOURCES) sim/bus/bus.c sim/port/firmware_node.c \
    sim/port/remote_firmware.c sim/programs/pil.c hal/slcan/slcan.c

$(PIL_PROCESS): $(PIL_PROCESS_SOURCES:%.c=$(BUILD)/host/%.o)
	@mkdir -p $(@D)
	@echo "  LINK $@"
	$(Q)$(CC) $^ -lode -lccd -lyaml -lm -o $@

pil pil-check: BOARD := $(or $(BOARD),mps2-an386)
pil-check:
	$(BOARD_CHECK)
	@[ -n "$(filter $(BOARD_IMAGE),$(SLCAN_IMAGES))" ] || { \
	    echo "make pil: BOARD='$(BOARD)': expected an image with a serial line to the simulator: $(SLCAN_IMAGES)" >&2; \
	    exit 2; }
	@case '$(TARGET_PROFILE)' in fd|classic) ;; *) \
	    echo "make pil: PROFILE='$(PROFILE)': expected fd or classic" >&2; exit 2;; esac
	@[ -z "$(CAN)$(filter-out 0 no,$(REALTIME))" ] || { \
	    echo "make pil: CAN='$(CAN)' REALTIME='$(REALTIME)': expected neither: in lockstep the bus is simulated" >&2; \
	    exit 2; }

pil: pil-check build target-check $(PIL_PROCESS)
pil: ## run an image in QEMU, in lockstep with the simulator; BOARD=; other options as for `make sim`
	@$(MAKE) --no-print-directory $(TARGET_BUILD)/$(BOARD_IMAGE)-pil/comanip.elf
	@$(RUN_ARGUMENTS); \
	$(PYTHON) -m comanip_dev.images.pil "$($(BOARD_IMAGE).emulator)" $(TARGET_BUILD)/$(BOARD_IMAGE)-pil/comanip.elf \
	    $(PIL_PROCESS) "$$@" $(ARGS); status=$$?; \
	[ -z "$(filter-out 0 no,$(PLOT))" ] || [ $$status -gt 1 ] || $(PYTHON) -m comanip.plotting "$$RUN_OUT" || exit; \
	exit $$status

pil-matrix-check size-check cycles-check:
	$(call ALL_IMAGES_CHECK,fd)

stack-check:
	$(call ALL_IMAGES_CHECK,$(TARGET_PROFILES))

bitexact-check: TARGET_PROFILE := $(or $(PROFILE),both)
bitexact-check:
	$(call ALL_IMAGES_CHECK,both)

pil-matrix: pil-matrix-check build target-check
pil-matrix: ## compare teleop, pour, mirror on each image with the host's runs; build/reports/pil.json (an hour)
	@$(PYTHON) tests/pil_matrix.py $(BUILD)

size: size-check deps targets
size: ## bytes of each module and image, against hal/size_budget.toml; UPDATE=1; build/reports/size.json
	@$(PYTHON) -m comanip_dev.images.size_report hal/size_budget.toml $(BUILD)/reports/size.json \
	    $(if $(filter-out 0 no,$(UPDATE)),--update) \
	    $(foreach image,$(IMAGES),$(image)=$(TARGET_BUILD)/$(image)/comanip.map)

# A port's folder may contain a separate stack budget.
STACK_BUDGETS := hal/stack_budget.toml $(sort $(wildcard hal/*/stack_budget.toml))
stack: stack-check deps targets
stack: ## maximum stack depth of each image, against the files stack_budget.toml of hal/; build/reports/stack.json
	@$(PYTHON) -m comanip_dev.images.stack_report $(STACK_BUDGETS) $(BUILD)/reports/stack.json \
	    $(foreach image,$(IMAGES),$(image)=$(TARGET_BUILD)/$(image))

bitexact: bitexact-check build $(VENV)/.installed-tests target-check
bitexact: ## check that every compiler and processor gives the same bytes; SMOKE=1; build/reports/bitexact.json
	@$(PYTHON) tests/bitexact/bitexact.py $(BUILD) $(if $(filter-out 0 no,$(SMOKE)),--smoke)

cycles: cycles-check build $(VENV)/.installed-tests target-check
cycles: ## instructions and modelled cycles per tick, against hal/cycle_budget.toml; UPDATE=1; build/reports/cycles.json
	@$(PYTHON) tests/cycles/cycles.py $(BUILD) hal/cycle_budget.toml $(if $(filter-out 0 no,$(UPDATE)),--update)

# Each line contains NAME, board, the compiler's prefix, specs file and options for the core, the emulator's command,
# and the word slcan (empty if the port has a CAN controller).
images: ## list the images for scripts: one line each, separated by tabs
	@printf '%s\t%s\t%s\t%s\t%s\t%s\t%s\n' $(foreach image,$(IMAGES), \
	    $(image) $($(image).board) $($(image).prefix) $($(image).specs) "$($(image).cpu)" "$($(image).emulator)" \
	    "$(if $(filter $(image),$(SLCAN_IMAGES)),slcan)")

# With -print-file-name, a compiler that does not find the specs file prints the bare name instead of a path.
target-check:
	@case '$(TARGET_PROFILE)' in fd|classic|both) ;; *) \
	    echo "make target: PROFILE='$(PROFILE)': expected one of $(TARGET_PROFILES)" >&2; exit 2;; esac
	@missing=; \
	$(foreach compiler,$(sort $(foreach image,$(IMAGES),$($(image).prefix)gcc:$($(image).specs))), \
	    compiler=$(word 1,$(subst :, ,$(compiler))); specs=$(word 2,$(subst :, ,$(compiler))); \
	    command -v $$compiler >/dev/null && test "$$($$compiler -print-file-name=$$specs)" != $$specs || \
	    missing="$$missing $$compiler with $$specs,";) \
	if [ -n "$$missing" ]; then \
	    echo "make target: not found:$${missing%,}. On Debian or Ubuntu: make target-deps, which installs" >&2; \
	    echo "  $(TARGET_PACKAGES)" >&2; \
	    exit 1; \
	fi

target-deps: ## install the cross compilers and QEMU (apt)
	@host_tools/apt-install.sh "make $@" $(TARGET_PACKAGES)
