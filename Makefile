# make demo   identify a simulated stage, package it as FMUs, run them, write out/demo/report.html
# make test   lint, C tests, Python tests
# make bench  ratios against peers and physical limits
# make clean  remove everything that was built
#
# Needs Python 3.11 or newer; everything else comes from the package registries.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed
TOOLS := $(VENV)/.tools
CBUILD := build/c
SOURCES := $(shell find python fmu_src -type f -not -path '*/__pycache__/*' -not -path '*/native/*' -not -path '*/fmus/*')

# the host's C compiler or, where there is none, zig's from PyPI
ifeq ($(shell command -v cc || command -v gcc || command -v clang),)
export CC := $(CURDIR)/$(BIN)/python -m ziglang cc
ZIGLANG := ziglang==0.17.0
endif

.PHONY: demo test lint ctest pytest bench clean install
install: $(INSTALLED)

$(TOOLS): requirements.lock
	$(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); \
	  echo "python3 -m venv does not work here; installing Debian's python3-venv"; \
	  apt-get install -y python3-venv && $(PYTHON) -m venv $(VENV); }
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements.lock $(ZIGLANG)
	touch $@

$(INSTALLED): $(TOOLS) pyproject.toml LICENSE README.md $(SOURCES)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --force-reinstall .
	touch $@

demo: $(INSTALLED)
	$(BIN)/it2hys run demo

test: lint ctest pytest

lint: $(TOOLS)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

ctest: $(TOOLS)
	$(BIN)/cmake -S fmu_src -B $(CBUILD) -G Ninja -DCMAKE_MAKE_PROGRAM=$(CURDIR)/$(BIN)/ninja \
	  -DPython_EXECUTABLE=$(CURDIR)/$(BIN)/python
	$(BIN)/cmake --build $(CBUILD)
	$(BIN)/ctest --test-dir $(CBUILD) --output-on-failure -j 2

pytest: $(INSTALLED)
	$(BIN)/python -m pytest -n 2

bench: $(INSTALLED) ctest
	$(BIN)/cmake --build $(CBUILD) --target bench

clean:
	rm -rf $(VENV) build out
