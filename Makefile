# comanip. `make` without a target prints the help, which consists of the comments after `##`.

BUILD := build
GENERATED := $(BUILD)/generated
VENV := .venv
PYTHON := $(VENV)/bin/python
DEVELOPMENT := host_tools/development/comanip_dev
CC := gcc
# V=1 prints the commands.
Q := $(if $(V),,@)

WARNINGS := -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror
# -ffp-contract=off: no fused multiply-add, so that results are bit-identical on every target. -fno-math-errno: with an
# FPU, sqrtf compiles to one instruction.
CORE_CFLAGS := -std=c11 -O2 -ffp-contract=off -fno-math-errno $(WARNINGS) -I$(GENERATED)
SIM_CFLAGS := $(CORE_CFLAGS) -D_POSIX_C_SOURCE=200809L
LINUX_CFLAGS := $(SIM_CFLAGS) -D_DEFAULT_SOURCE -pthread

CORE_SOURCES := $(filter-out firmware/main.c,$(wildcard firmware/*.c firmware/*/*.c firmware/*/*/*.c)) \
    $(GENERATED)/comanip_dbc.c
FIRMWARE_FILES := $(wildcard firmware/*.[ch] firmware/*/*.[ch] firmware/*/*/*.[ch])
# Sources of the simulated world, which comanip-sim, comanip-plant and comanip-pil share. The bus and the connection to
# the firmware are not among them, because they differ between these programs.
SIM_SOURCES := $(filter-out sim/programs/% sim/port/% sim/bus/bus.c sim/bus/live_bus.c,$(wildcard sim/*/*.c)) \
    hal/common/frame_time.c hal/linux/hub_path.c
HOST_SOURCES := firmware/main.c hal/common/no_store.c $(SIM_SOURCES) sim/bus/bus.c sim/port/firmware_node.c \
    sim/port/local_firmware.c sim/programs/simulator.c
SIMULATOR := $(BUILD)/host/comanip-sim
HOST_OBJECTS := $(CORE_SOURCES:%.c=$(BUILD)/host/%.o) $(HOST_SOURCES:%.c=$(BUILD)/host/%.o)

# Names of the Debian and Ubuntu packages that are required in addition to git and make.
DEBIAN_PACKAGES := gcc libc6-dev libode-dev libccd-dev libyaml-dev can-utils python3 python3-dev python3-venv
INSTALL_DEPS := host_tools/install-deps.sh "$(DEBIAN_PACKAGES)" $(VENV) host_tools/requirements.txt

# Two processes on a real bus: the firmware on the Linux port, and the plant.
FIRMWARE_PROCESS := $(BUILD)/linux/comanip-firmware
PLANT_PROCESS := $(BUILD)/linux/comanip-plant
CAN_SOURCES := $(wildcard hal/linux/can_*.c) hal/linux/pace.c hal/linux/run_options.c
FIRMWARE_PROCESS_SOURCES := $(CORE_SOURCES) firmware/main.c $(wildcard hal/linux/*.c)
PLANT_PROCESS_SOURCES := $(CORE_SOURCES) $(CAN_SOURCES) $(SIM_SOURCES) sim/bus/live_bus.c sim/programs/plant.c
LINUX_OBJECTS := $(sort $(FIRMWARE_PROCESS_SOURCES:%.c=$(BUILD)/host/%.o) \
    $(PLANT_PROCESS_SOURCES:%.c=$(BUILD)/host/%.o))

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help deps build golden sim run-firmware run-plant experiments gain-search following test test-socketcan
.PHONY: test-images bench arms bus-doc schema bus-report target target-deps clean

help: ## print this text
	@echo "comanip: a person and a robot arm work together over a CAN bus"
	@echo
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):[^#]*## ?/  make \1\t/' | expand -t 22
	@echo
	@printf '%s' "  make sim SCENARIO=pour|teleop|mirror|handover|crank|file.yaml"
	@echo " TRACKER=file.csv SEED=n OUT=dir PLOT=1 ARGS='...'"
	@echo "      PLOT=1 writes OUT/report/*.png; ARGS are further options of the simulator: make sim ARGS=--help"
	@echo "      PROFILE=classic: classic CAN at 250 Hz instead of CAN FD at 1 kHz; also for run-firmware and run-plant"
	@echo "      CAN=hub REALTIME=1 runs in real time and shows the bus to make candump"
	@echo "  make experiments SEEDS=20 OUT=dir"
	@echo "  make run-firmware CAN=vcan0 SLOW=n PARAMETERS=file"
	@echo "      and in a second terminal: make run-plant CAN=vcan0 SLOW=n SCENARIO=... OUT=dir ARGS='...'"

# ---- dependencies

# Every build runs this target first. It takes a fraction of a second if nothing is missing.
deps: ## install what is missing: system packages through apt, Python packages into .venv/
	@$(INSTALL_DEPS)

$(VENV)/.installed-tests: tests/requirements.txt | deps
	@echo "comanip: installing the tests' Python packages into $(VENV)/"
	@$(PYTHON) -m pip install --quiet --disable-pip-version-check -r $<
	@touch $@

# ---- build

HOST_PROGRAMS := $(SIMULATOR) $(FIRMWARE_PROCESS) $(PLANT_PROCESS)
build: deps $(HOST_PROGRAMS) $(BUILD)/python/.built ## build simulator, firmware and plant processes, Python binding

$(GENERATED)/.generated: $(DEVELOPMENT)/codegen.py $(wildcard $(DEVELOPMENT)/schema/*.py) \
    host_tools/comanip/parameters.py host_tools/comanip/tasks.py $(wildcard firmware/schema/*) $(FIRMWARE_FILES) | deps
	@echo "  GENERATE $(GENERATED)/"
	$(Q)$(PYTHON) -m comanip_dev.codegen $(GENERATED)
	@touch $@

$(GENERATED)/comanip_dbc.c: $(GENERATED)/.generated ;

$(SIMULATOR): $(HOST_OBJECTS)
	@echo "  LINK $@"
	$(Q)$(CC) $^ -lode -lccd -lyaml -lm -o $@

$(FIRMWARE_PROCESS): $(FIRMWARE_PROCESS_SOURCES:%.c=$(BUILD)/host/%.o)
	@mkdir -p $(@D)
	@echo "  LINK $@"
	$(Q)$(CC) $^ -pthread -lm -o $@

$(PLANT_PROCESS): $(PLANT_PROCESS_SOURCES:%.c=$(BUILD)/host/%.o)
	@mkdir -p $(@D)
	@echo "  LINK $@"
	$(Q)$(CC) $^ -lode -lccd -lyaml -lm -o $@

$(BUILD)/host/sim/%.o $(BUILD)/host/hal/%.o $(BUILD)/host/host_tools/%.o: CORE_CFLAGS := $(SIM_CFLAGS)
$(BUILD)/host/hal/linux/%.o: CORE_CFLAGS := $(LINUX_CFLAGS)
$(BUILD)/host/%.o: %.c Makefile $(GENERATED)/.generated
	@mkdir -p $(@D)
	@echo "  CC $<"
	$(Q)$(CC) $(CORE_CFLAGS) -MMD -MP -c $< -o $@

$(BUILD)/python/.built: $(DEVELOPMENT)/build_core.py $(wildcard host_tools/comanip/_binding/*) \
    $(GENERATED)/.generated $(FIRMWARE_FILES) host_tools/pyproject.toml
	@echo "  BIND host_tools/comanip/_core"
	$(Q)$(PYTHON) -m comanip_dev.build_core --generated $(GENERATED) --build-dir $(BUILD)/python --cflags "$(CORE_CFLAGS)"
	@touch $@

-include $(HOST_OBJECTS:.o=.d) $(LINUX_OBJECTS:.o=.d)

# ---- use

# The values of SCENARIO=, OUT= etc. are passed through the environment, so that they may contain quotes and spaces. The
# program gets no option for an empty variable.
sim run-plant pil: export RUN_SCENARIO := $(SCENARIO)
sim run-plant pil: export RUN_TRACKER := $(TRACKER)
sim run-plant pil: export RUN_SEED := $(SEED)
sim run-plant run-firmware pil: export RUN_PROFILE := $(PROFILE)
sim run-plant pil: export RUN_OUT := $(or $(OUT),out/$(basename $(notdir $(or $(SCENARIO),pour))))
RUN_ARGUMENTS = case ' $(ARGS)' in *' --scenario'*|*' --out'*) \
	    echo "make $@: give the scenario and the folder as SCENARIO= and OUT=, not in ARGS" >&2; exit 2;; esac; \
	set -- --out "$$RUN_OUT"; \
	[ -z "$$RUN_SCENARIO" ] || set -- "$$@" --scenario "$$RUN_SCENARIO"; \
	[ -z "$$RUN_TRACKER" ] || set -- "$$@" --tracker "$$RUN_TRACKER"; \
	[ -z "$$RUN_SEED" ] || set -- "$$@" --seed "$$RUN_SEED"; \
	[ -z "$$RUN_PROFILE" ] || set -- "$$@" --profile "$$RUN_PROFILE"
sim: build ## run a scenario; prints a pass/fail table and the paths of the files written
	@$(RUN_ARGUMENTS); \
	[ -z "$(filter-out 0 no,$(REALTIME))" ] || set -- "$$@" --real-time; \
	case '$(CAN)' in '') ;; hub) set -- "$$@" --hub vcan0;; \
		*) echo "make sim: CAN='$(CAN)': expected hub; for a bus of the kernel use make run-plant and run-firmware" >&2; \
		exit 2;; esac; \
	$(SIMULATOR) "$$@" $(ARGS); status=$$?; \
	[ -z "$(filter-out 0 no,$(PLOT))" ] || [ $$status -gt 1 ] || $(PYTHON) -m comanip.plotting "$$RUN_OUT" || exit; \
	exit $$status

# CAN is the name of a kernel interface or of a hub.
RUN_ON_CAN = --can "$(or $(CAN),vcan0)" --slow "$(or $(SLOW),1)"
run-firmware: export RUN_PARAMETERS := $(PARAMETERS)
run-firmware: build ## run the firmware as a process on CAN=vcan0 until Ctrl-C; SLOW=n: n times slower; PARAMETERS=file
	@$(FIRMWARE_PROCESS) $(RUN_ON_CAN) $${RUN_PROFILE:+--profile "$$RUN_PROFILE"} \
	    $${RUN_PARAMETERS:+--parameters "$$RUN_PARAMETERS"}

run-plant: build ## run the simulated plant as a second process on CAN=vcan0; options as for `make sim`
	@$(RUN_ARGUMENTS); \
	$(PLANT_PROCESS) $(RUN_ON_CAN) "$$@" $(ARGS)

SEEDS := 20
experiments: export RUN_OUT := $(or $(OUT),out/experiments)
experiments: build ## run the five experiments with SEEDS seeds and recordings; compare with the paper's controller
	@$(PYTHON) -m comanip_dev.experiments --seeds "$(SEEDS)" --out "$$RUN_OUT" $(ARGS)

gain-search: export RUN_OUT := $(or $(OUT),out/gain-search)
gain-search: build ## repeat the search for the gains of docs/gains.md (up to an hour)
	@$(PYTHON) -m comanip_dev.experiments.gain_search --out "$$RUN_OUT" $(ARGS)

$(VENV)/.installed-following: host_tools/following-requirements.txt | deps
	@echo "comanip: installing the packages that make following compares with into $(VENV)/"
	@$(PYTHON) -m pip install --quiet --disable-pip-version-check --no-deps -r $<
	@touch $@

following: export RUN_OUT := $(or $(OUT),out/following)
following: export RUN_RECORDINGS := $(RECORDINGS)
following: build $(VENV)/.installed-following ## measure how closely the robot follows hands; QUICK=1, RECORDINGS=folder
	@$(PYTHON) -m comanip_dev.following --out "$$RUN_OUT" $${RUN_RECORDINGS:+--recordings "$$RUN_RECORDINGS"} \
	    $(if $(filter-out 0 no,$(QUICK)),--quick) $(ARGS)

# pytest starts one worker per processor. tests/groups.py names the tests that must run in the same worker. Debugging
# with --pdb requires PYTEST_ARGS='-n 0', which runs the tests without workers.
PYTEST_WORKERS := -n auto --no-loadscope-reorder

test: build $(VENV)/.installed-tests ## run all tests: maths, bus, closed loop, recordings, two target images
	@$(PYTHON) -m pytest tests $(PYTEST_WORKERS) $(PYTEST_ARGS)

# The script boots user-mode Linux, a kernel with CAN modules, and installs it through apt if it is missing.
test-socketcan: build $(VENV)/.installed-tests ## run the tests on the kernel's SocketCAN, in user-mode Linux (2 min)
	@REQUIRED=$(REQUIRED) tests/socketcan/run.sh $(PYTHON) $(PYTEST_ARGS)

test-images: build $(VENV)/.installed-tests ## run the tests of all target images (5 min); `make test` runs two
	@ALL_IMAGES=1 $(PYTHON) -m pytest tests/test_target.py tests/test_pil.py tests/test_stack_report.py \
	    tests/test_size_report.py tests/test_bitexact.py $(PYTEST_ARGS)

golden: build $(VENV)/.installed-tests ## record the golden logs again; see tests/golden/golden.py
	@$(PYTHON) tests/golden/golden.py $(ARGS)

include tests/bench/bench.mk

bench: build $(VENV)/.installed-tests $(BENCH)/ticks ## compare our tick with Pinocchio, KDL, MuJoCo and dqrobotics
	@$(PYTHON) tests/bench/bench.py $(BUILD)

arms: deps ## generate the C code of the arms, and their names in comanip.dbc, from firmware/arms/*.toml
	@$(PYTHON) -m comanip_dev.arms.codegen
	@$(PYTHON) -m comanip_dev.bus.doc docs/bus.md

schema: deps ## update comanip.dbc, docs/bus.md and docs/parameters.md from firmware/schema/
	@$(PYTHON) -m comanip_dev.codegen --schema
	@$(PYTHON) -m comanip_dev.bus.doc docs/bus.md
	@$(PYTHON) -m comanip_dev.schema.parameters_doc docs/parameters.md

bus-doc: schema # the former name of `make schema`, which still works

bus-report: deps ## print load and worst-case response time of every frame; build/reports/bus.json
	@$(PYTHON) -m comanip_dev.bus.report $(BUILD)/reports/bus.json

include tests/rest/rest.mk
include tests/sanitised/sanitised.mk

include hal/target.mk
include host_tools/hub/hub.mk
include host_tools/check.mk

clean: ## remove everything that was built (not .venv/)
	rm -rf $(BUILD) host_tools/comanip/_core*.so
