# Builds the hub, and the shim through which can-utils and python-can use it. Included by the Makefile, which defines
# BUILD, CC, Q, WARNINGS and VENV.

HUB_CFLAGS := -std=c11 -O2 -D_GNU_SOURCE $(WARNINGS)
HUB_SOURCES := $(wildcard host_tools/hub/*.c) hal/linux/hub_path.c
SHIM_SOURCES := $(wildcard host_tools/shim/*.c) hal/linux/hub_path.c
HUB := $(BUILD)/host/comanip-hub
SHIM := $(BUILD)/host/libcomanip-can.so
WITH_CAN := $(BUILD)/host/with-can
CAN_BUS = $(or $(filter-out hub,$(CAN)),vcan0)

FUZZ_SECONDS := 600
FUZZ_PROGRAMS := $(BUILD)/fuzz/fuzz_socketcand $(BUILD)/fuzz/fuzz_unix
FUZZ_PACKAGES := clang libclang-rt-dev

.PHONY: hub candump fuzz-hub fuzz-deps test-hub-load check-c-hub

build: $(HUB) $(SHIM) $(WITH_CAN)

$(HUB): $(HUB_SOURCES) $(wildcard host_tools/hub/*.h) hal/linux/hub_path.h | deps
	@mkdir -p $(@D)
	@echo "  CC LINK $@"
	$(Q)$(CC) $(HUB_CFLAGS) $(HUB_SOURCES) -o $@

$(SHIM): $(SHIM_SOURCES) $(wildcard host_tools/shim/*.h) hal/linux/hub_path.h | deps
	@mkdir -p $(@D)
	@echo "  CC LINK $@"
	$(Q)$(CC) $(HUB_CFLAGS) -fPIC -fvisibility=hidden -shared $(SHIM_SOURCES) -ldl -pthread -o $@

$(WITH_CAN): host_tools/shim/with-can
	@mkdir -p $(@D)
	$(Q)cp $< $@

hub: build ## run a CAN bus without CAN in the kernel, for processes on this machine (CAN=vcan0), until Ctrl-C
	@$(HUB) --bus "$(CAN_BUS)" $(ARGS)

candump: build ## print live traffic of CAN=vcan0 (the kernel's interface, else the hub); ARGS go to candump
	@host_tools/hub/candump.sh "$(WITH_CAN)" "$(CAN_BUS)" $(ARGS)

test-hub-load: build $(VENV)/.installed-tests ## load the hub: 20,000 frames/s for a minute, four listeners, one stalled
	@$(PYTHON) tests/hub_load.py $(ARGS)

fuzz-deps: ## install clang and libFuzzer for fuzz-hub (apt)
	@[ "$$(id -u)" = 0 ] || sudo=sudo; $$sudo apt-get install -y -qq --no-install-recommends $(FUZZ_PACKAGES)

$(BUILD)/fuzz/%: tests/fuzz/%.c tests/fuzz/fuzz_hub.c $(HUB_SOURCES) $(wildcard host_tools/hub/*.h tests/fuzz/*.h) \
    hal/linux/hub_path.h
	@mkdir -p $(@D)
	@echo "  CC LINK $@"
	$(Q)clang $(HUB_CFLAGS) -g -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all $< tests/fuzz/fuzz_hub.c \
	    $(filter-out %/main.c,$(HUB_SOURCES)) -o $@

# -close_fd_mask=2 discards the hub's messages about refused packets, but keeps those of fuzzer and sanitisers.
fuzz-hub: $(FUZZ_PROGRAMS) ## fuzz both interfaces of the hub under ASan and UBSan, FUZZ_SECONDS=600 each
	@for program in $(FUZZ_PROGRAMS); do \
	    corpus=$(BUILD)/fuzz/corpus-$$(basename $$program); mkdir -p $$corpus; \
	    echo "$$program: $(FUZZ_SECONDS) s"; \
	    (ulimit -c 0; ASAN_OPTIONS=abort_on_error=0 $$program -max_total_time=$(FUZZ_SECONDS) -max_len=4096 \
	        -close_fd_mask=2 -artifact_prefix=$(BUILD)/fuzz/ $$corpus 2>$$corpus.log) || \
	        { tail -n 40 $$corpus.log >&2; exit 1; }; \
	    tail -n 2 $$corpus.log; \
	done

check-c: check-c-hub
check-c-hub:
	@for source in $(HUB_SOURCES) $(wildcard host_tools/shim/*.c tests/fuzz/*.c); do \
	    clang $(HUB_CFLAGS) -fsyntax-only $$source || exit 1; done
