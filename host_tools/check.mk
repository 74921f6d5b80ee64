# Static checks of the sources.

C_FILES = $(shell git ls-files '*.[ch]')
# Files in which no formatter wraps the lines, or in which none wraps the comments (C).
PROSE := Makefile '*.[ch]' '*.md' '*.mk' '*.toml' '*.yaml'
RUFF := $(VENV)/bin/ruff
CLANG_FORMAT := $(VENV)/bin/clang-format
.PHONY: check check-deps check-c check-directions check-format check-schema format

$(VENV)/.installed-check: host_tools/check-requirements.txt | deps
	@echo "comanip: installing formatter and linter into $(VENV)/"
	@$(PYTHON) -m pip install --quiet --disable-pip-version-check -r $<
	@touch $@

check: check-format check-directions check-c check-schema ## check format, lint, schema, includes; compile with clang
	@echo "check: passed"

check-format: $(VENV)/.installed-check
	@$(CLANG_FORMAT) --dry-run --Werror $(C_FILES)
	@$(RUFF) format --quiet --check . || \
	    { $(RUFF) format --check . | head -20; echo "check: not formatted, run make format" >&2; exit 1; }
	@$(RUFF) check --quiet .
	@! LC_ALL=C.UTF-8 git grep -nIE '^[^|].{120}' -- $(PROSE) || \
	    { echo "make check: the lines above are too long: expected at most 120 columns, except in tables" >&2; exit 1; }

format: $(VENV)/.installed-check ## format all C and Python
	@$(CLANG_FORMAT) -i $(C_FILES)
	@$(RUFF) format --quiet .
	@$(RUFF) check --quiet --fix .

check-schema: deps
	@$(PYTHON) -m comanip_dev.schema.readers

check-directions: deps
	@$(PYTHON) tests/check/include_directions.py

check-deps: ## install clang and its sanitisers through apt
	@host_tools/apt-install.sh "make $@" clang libclang-rt-dev

check-c: $(GENERATED)/.generated
	@command -v clang >/dev/null || \
	    { echo "make check: needs clang. On Debian or Ubuntu: make check-deps" >&2; exit 1; }
	@for source in $(CORE_SOURCES) firmware/main.c; do for profile in BOTH FD_ONLY CLASSIC_ONLY; do \
	    clang $(CORE_CFLAGS) -DCAN_$$profile -fsyntax-only $$source || exit 1; done; done
	@for source in $(wildcard hal/linux/*.c); do clang $(LINUX_CFLAGS) -fsyntax-only $$source || exit 1; done
	@for source in hal/common/frame_time.c hal/common/no_store.c $(wildcard sim/*/*.c); do \
	    clang $(SIM_CFLAGS) -fsyntax-only $$source || exit 1; done
