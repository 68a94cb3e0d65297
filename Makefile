# Each target makes .venv when it is missing or out of date, so each is the only command needed.
# `make demo TORCH=no` and `make app TORCH=no` install without torch, gigabytes less; the tests need it.
PYTHON ?= python3
VENV := .venv
BUNDLE := $(VENV)-bundle
BIN := $(VENV)/bin
# What is imported is compiled then: a tenth of what is installed.
PIP := pip install --no-compile
INSTALL := $(BIN)/python -m $(PIP)
ifeq ($(TORCH),no)
# pip cannot leave out a dependency.
INSTALL := $(INSTALL) --quiet --constraint constraints.txt uv && \
	$(BIN)/uv pip install --python $(BIN)/python --overrides install/without-torch.txt
endif

.PHONY: demo app test lint format clean bundle system

demo: $(VENV)/.prepared
	$(BIN)/vesselsplat demo --out out/demo

app: $(VENV)/.prepared
	$(BIN)/vesselsplat

LINT = $(BIN)/ruff format --check . && $(BIN)/ruff check . && $(BIN)/mypy && $(BIN)/lint-imports

# On two cores: kernels are compiled beside the linters, once for both processes of the suite; so are the tests.
# The suite starts hundreds of programs: what they load is compiled once, also where the system says otherwise.
test: export PYTHONDONTWRITEBYTECODE :=
test: $(VENV)/.installed-test
	($(LINT) && $(BIN)/python -m pytest --collect-only -qq >/dev/null) & $(BIN)/vesselsplat prepare && $(BIN)/python -m pytest -n 2 --dist worksteal && wait $$!

lint: $(VENV)/.installed-test
	$(LINT)

format: $(VENV)/.installed-test
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

# A folder that runs without Python: dist/vesselsplat. uv leaves out what the bundle goes without.
bundle: install/bundle/overrides.txt pyproject.toml constraints.txt | system
	test -x $(BUNDLE)/bin/pip || $(PYTHON) -m venv $(BUNDLE)
	$(BUNDLE)/bin/python -m pip install --quiet --constraint constraints.txt uv
	$(BUNDLE)/bin/uv pip install --quiet --python $(BUNDLE)/bin/python --constraint constraints.txt \
		--overrides install/bundle/overrides.txt --reinstall-package vesselsplat '.[bundle]'
	$(BUNDLE)/bin/pyinstaller --log-level WARN --noconfirm --workpath $(BUNDLE)/work install/bundle/vesselsplat.spec
	$(BUNDLE)/bin/python -m install.bundle.finish dist/vesselsplat $(BUNDLE)/work/vesselsplat/COLLECT-00.toc

# Compiled kernels lie in __pycache__; numba does not see that a function inlined from another file has changed.
clean:
	rm -rf $(VENV) $(BUNDLE) out dist
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# What the system lacks for the targets asked for, before anything is downloaded.
system:
	@PYTHON=$(PYTHON) VENV=$(VENV) install/system-packages $(or $(MAKECMDGOALS),demo)

$(VENV)/.installed: pyproject.toml constraints.txt | system
	test -x $(BIN)/pip || $(PYTHON) -m venv $(VENV)
	$(INSTALL) --quiet --constraint constraints.txt --editable .
	touch $@

# Every kernel is compiled once, so that no first use waits for it.
$(VENV)/.prepared: $(VENV)/.installed
	$(BIN)/vesselsplat prepare
	touch $@

# In one go with what all targets need.
$(VENV)/.installed-test: pyproject.toml constraints.txt | system
	test -x $(BIN)/pip || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m $(PIP) --quiet --constraint constraints.txt --editable '.[test]'
	touch $(VENV)/.installed $@
