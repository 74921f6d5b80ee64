# `make rest` runs the firmware's tick in a closed loop with modelled drives, for thousands of cases. The Makefile
# includes this file and defines BUILD, GENERATED, CORE_CFLAGS and CORE_SOURCES.

REST := $(BUILD)/rest
REST_SOURCES := $(CORE_SOURCES) tests/rest/loop.c

$(REST)/%.o: %.c Makefile tests/rest/rest.mk $(FIRMWARE_FILES) $(GENERATED)/.generated tests/rest/loop.h
	@mkdir -p $(@D)
	@echo "  CC [rest] $<"
	$(Q)$(CC) $(CORE_CFLAGS) -fPIC -c $< -o $@

$(REST)/loop.so: $(REST_SOURCES:%.c=$(REST)/%.o)
	@echo "  LINK $@"
	$(Q)$(CC) -shared -Wl,-z,defs $^ -lm -o $@

.PHONY: rest
rest: build $(VENV)/.installed-tests $(REST)/loop.so ## check that the arm comes to rest (minutes)
	@$(PYTHON) tests/rest/rest.py $(BUILD) $(ARGS)
