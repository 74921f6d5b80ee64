# Builds build/bench/ticks, the program whose ticks `make bench` measures. The Makefile includes this file and defines
# BUILD, GENERATED and CORE_CFLAGS.

BENCH := $(BUILD)/bench
# The shell expands this pattern in the recipes. make cannot, because it reads this file before the folder is installed.
BENCH_SITE := $(VENV)/lib/python3*/site-packages
BENCH_ARMS := six seven

# All contenders are compiled for the same processor. Apart from that, our code is compiled as in the product.
# EIGEN_MAX_ALIGN_BYTES has the value with which Debian compiles KDL, and the BOOST_MPL macros have the values of
# Pinocchio's CMake files.
BENCH_PROCESSOR := -march=x86-64-v3
BENCH_CXXFLAGS = -std=c++17 -O3 -DNDEBUG $(BENCH_PROCESSOR) -DEIGEN_MAX_ALIGN_BYTES=16 -DBOOST_MPL_LIMIT_LIST_SIZE=30 \
    -DBOOST_MPL_LIMIT_VECTOR_SIZE=30 -DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS \
    -isystem $(BENCH_SITE)/cmeel.prefix/include \
    -isystem $(BENCH_SITE)/mujoco/include -isystem /usr/include/eigen3
BENCH_C := $(wildcard firmware/maths/*.c firmware/arms/*.c firmware/control/arms/*.c) tests/bench/tick.c \
    $(addprefix firmware/control/,arm_ik.c cooperation.c differential_ik.c differential_ik_general.c \
    differential_ik_isotropic.c joints_at_limit.c position_priority.c task.c)
BENCH_WRITTEN := $(BENCH_ARMS:%=$(BENCH)/arms/%.c) $(BENCH_ARMS:%=$(BENCH)/control/arms/%_ik.c)
BENCH_OBJECTS := $(BENCH_C:%.c=$(BENCH)/%.o) $(BENCH_WRITTEN:.c=.o) \
    $(patsubst tests/bench/%.cpp,$(BENCH)/%.cpp.o,$(wildcard tests/bench/*.cpp))
BENCH_PACKAGES := g++ liborocos-kdl-dev libeigen3-dev valgrind

$(VENV)/.installed-bench: tests/bench/requirements.txt | deps
	@host_tools/apt-install.sh "make bench" $(BENCH_PACKAGES)
	@echo "comanip: installing the libraries that make bench compares with into $(VENV)/"
	@$(PYTHON) -m pip install --quiet --disable-pip-version-check --no-deps -r $<
	@touch $@

$(BENCH)/arms/%.c $(BENCH)/control/arms/%_ik.c: tests/bench/arms/%.toml $(wildcard $(DEVELOPMENT)/arms/*.py) | deps
	@mkdir -p $(BENCH)/arms
	@cp $< $(BENCH)/arms
	$(Q)$(PYTHON) -m comanip_dev.arms.codegen $(BENCH)/arms/$*.toml >/dev/null

.SECONDARY: $(BENCH_WRITTEN) # keeps the generated sources after compilation
BENCH_CC = $(CC) $(CORE_CFLAGS) $(BENCH_PROCESSOR) -I$(BENCH)/control/arms -Ifirmware/arms -Ifirmware/control/arms
$(BENCH)/%.o: $(BENCH)/%.c Makefile tests/bench/bench.mk $(FIRMWARE_FILES)
	@echo "  CC $<"
	$(Q)$(BENCH_CC) -c $< -o $@

$(BENCH)/%.o: %.c Makefile tests/bench/bench.mk $(FIRMWARE_FILES) $(GENERATED)/.generated $(BENCH_WRITTEN) \
    tests/bench/tick.h
	@mkdir -p $(@D)
	@echo "  CC $<"
	$(Q)$(BENCH_CC) -c $< -o $@

$(BENCH)/%.cpp.o: tests/bench/%.cpp tests/bench/bench.mk $(wildcard tests/bench/*.h tests/bench/*.hpp) \
    $(VENV)/.installed-bench
	@mkdir -p $(@D)
	@echo "  CXX $<"
	$(Q)g++ $(BENCH_CXXFLAGS) -c $< -o $@

$(BENCH)/ticks: $(BENCH_OBJECTS)
	@echo "  LINK $@"
	$(Q)mujoco=$$(realpath $(BENCH_SITE)/mujoco/libmujoco.so*) && \
	g++ $(BENCH_OBJECTS) "$$mujoco" -Wl,-rpath,"$$(dirname "$$mujoco")" -lorocos-kdl -lm -o $@
