# make demo   identify a simulated stage, package it as FMUs, run them, write out/demo/report.html
# make test   lint, C tests, the same under sanitizers, valgrind and a static analyzer, Python tests
# make bench  ratios against peers (REFERENCE_FMUS=folder:folder) and limits, the whole diagnosis suite; long fuzzing and soak
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

# where there is no C compiler: zig's from PyPI (the wheel's build backend sees to itself); for any processor,
# because valgrind knows not all that this one may have
ifeq ($(shell command -v cc || command -v gcc || command -v clang),)
WITH_CC := CC="$(CURDIR)/$(BIN)/python -m ziglang cc -mcpu=baseline"
endif

# a checker and a master from Maven Central, where there is Maven; their tests skip with a reason elsewhere
VDMCHECK := build/vdmcheck
MAESTRO := build/maestro
VDMCHECK_JARS := org.into-cps.vdmcheck.fmi2:vdmcheck2:1.1.3 org.into-cps.vdmcheck.fmi2:static-model:1.1.3 \
        org.into-cps.vdmcheck.fmi2:rule-model:1.1.3 org.into-cps.vdmcheck:xsd2vdm:1.1.3 \
        org.into-cps.vdmcheck:fmuReader:1.1.3 dk.au.ece.vdmj:vdmj:4.5.0 dk.au.ece.vdmj:annotations:4.5.0
MAESTRO_JARS := org.into-cps.maestro:maestro:2.3.0:jar:jar-with-dependencies
$(VDMCHECK)/.fetched: JARS = $(VDMCHECK_JARS)
$(MAESTRO)/.fetched: JARS = $(MAESTRO_JARS)
$(VDMCHECK)/.fetched $(MAESTRO)/.fetched:
	mkdir -p $(@D)
	for jar in $(JARS); do \
	  mvn -q -B org.apache.maven.plugins:maven-dependency-plugin:3.6.1:copy -Dartifact=$$jar \
	    -DoutputDirectory=$(CURDIR)/$(@D) || exit; \
	done
	touch $@

.PHONY: demo test lint ctest hardened pytest bench clean install
install: $(INSTALLED)

$(TOOLS): requirements.lock
	$(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); \
	  echo "python3 -m venv does not work here; installing Debian's python3-venv"; \
	  apt-get install -y python3-venv && $(PYTHON) -m venv $(VENV); }
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements.lock
	touch $@

$(INSTALLED): $(TOOLS) pyproject.toml LICENSE README.md $(SOURCES)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --force-reinstall .
	touch $@

demo: $(INSTALLED)
	$(BIN)/it2hys run demo

test: lint ctest hardened pytest

lint: $(TOOLS)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

ctest: $(TOOLS)
	$(WITH_CC) $(BIN)/cmake -S fmu_src -B $(CBUILD) -G Ninja -DCMAKE_MAKE_PROGRAM=$(CURDIR)/$(BIN)/ninja \
	  -DPython_EXECUTABLE=$(CURDIR)/$(BIN)/python
	$(BIN)/cmake --build $(CBUILD)
	$(BIN)/ctest --test-dir $(CBUILD) --output-on-failure -j 2

hardened: ctest
	$(WITH_CC) PATH="$(CURDIR)/$(BIN):$$PATH" fmu_src/tests/hardened.sh $(CURDIR)/$(CBUILD) \
	  $(CURDIR)/$(BIN)/python

pytest: $(INSTALLED) $(if $(shell command -v mvn),$(VDMCHECK)/.fetched $(MAESTRO)/.fetched)
	# two workers are all the cores there may be: no threads besides
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n 2

bench: $(INSTALLED) ctest
	$(BIN)/cmake --build $(CBUILD) --target bench
	$(BIN)/python benchmarks/identification.py
	$(BIN)/python benchmarks/diagnosis.py
	$(BIN)/python benchmarks/sweep.py $(CBUILD)/bench/bare_loop

clean:
	rm -rf $(VENV) build out
