# `make test-sanitised` runs the tests that use the compiled core, with a core built by clang with AddressSanitizer and
# UndefinedBehaviorSanitizer. The Makefile includes this file and defines BUILD, GENERATED, CORE_CFLAGS, CORE_SOURCES.

SANITISED := $(BUILD)/sanitised
# Unsigned overflow is not checked, because counters and clocks wrap by design. Implicit conversions are not checked,
# because -Wconversion already rejects those that lose bits; it accepts only ++ on a narrow counter, which may wrap.
SANITISERS := address,undefined,float-cast-overflow,float-divide-by-zero,local-bounds
SANITISED_CFLAGS = $(CORE_CFLAGS) -O1 -g -fno-omit-frame-pointer -fsanitize=$(SANITISERS) -fno-sanitize-recover=all
SANITISER_RUNTIME = $(shell clang -print-file-name=libclang_rt.asan-$(shell uname -m).so 2>/dev/null)
SANITISED_FROM := Makefile tests/sanitised/sanitised.mk $(GENERATED)/.generated $(FIRMWARE_FILES)

.PHONY: sanitised-check test-sanitised

$(SANITISED)/.core: $(DEVELOPMENT)/build_core.py $(wildcard host_tools/comanip/_binding/*) $(SANITISED_FROM)
	@echo "  BIND [sanitised] $(SANITISED)"
	$(Q)CC=clang $(PYTHON) -m comanip_dev.build_core --generated $(GENERATED) --build-dir $(SANITISED)/core \
	    --folder $(SANITISED) --cflags "$(SANITISED_CFLAGS)"
	@touch $@

$(SANITISED)/rest/%.o: %.c tests/rest/loop.h $(SANITISED_FROM)
	@mkdir -p $(@D)
	@echo "  CC [sanitised] $<"
	$(Q)clang $(SANITISED_CFLAGS) -fPIC -c $< -o $@

# The loop of tests/rest contains the core and is therefore built with sanitisers, too. Its tests expect generated/ and
# host/ (the simulator) in the same build folder, so these are linked.
$(SANITISED)/rest/loop.so: $(REST_SOURCES:%.c=$(SANITISED)/rest/%.o)
	@echo "  LINK $@"
	$(Q)clang $(SANITISED_CFLAGS) -shared $^ -lm -o $@
	@ln -sfn $(abspath $(GENERATED)) $(SANITISED)/generated
	@ln -sfn $(abspath $(BUILD))/host $(SANITISED)/host

sanitised-check:
	@[ -e "$(SANITISER_RUNTIME)" ] || \
	    { echo "make test-sanitised: needs clang and its runtime. On Debian or Ubuntu: make check-deps" >&2; exit 1; }

test-sanitised: sanitised-check build $(VENV)/.installed-tests $(SANITISED)/.core $(SANITISED)/rest/loop.so
test-sanitised: ## run the core's tests again, with the core compiled with ASan and UBSan
	@$(PYTHON) tests/sanitised/run.py $(SANITISED) $(SANITISER_RUNTIME) $(PYTEST_WORKERS) $(PYTEST_ARGS)
