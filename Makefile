# make demo   identify a simulated stage, package it as FMUs, run them, write out/demo/report.html
# make test   lint, C tests, the same under sanitizers, valgrind and a static analyzer, Python tests, installation
# make docs   the documentation's site, build/docs/html/index.html; the code of its pages is run
# make diagnosis  long diagnoses, of the measured stage too, and of simulated ones that nothing was chosen on (SEEDS=30000, CASES=6): a gate, hours
# make design  records designed between two effects, on simulated stages (SEEDS=90000, COUNT=10, NOISE=1): do they decide? hours
# make own-effects  the worked examples of own effects on simulated stages (SEEDS=20, KIND=given): hours; goes on where it ended
# make bench  ratios against peers (REFERENCE_FMUS=their sources) and an earlier commit (BEFORE=commit), growth, soak; limits
# make modelica  the Modelica library's release archive, dist/IT2Hysteresis-VERSION.zip
# make clean  remove everything that was built
#
# Needs Python 3.11 or newer; everything else comes from the package registries.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# what is not compiled at once is compiled when it is first used, which is far less of it
PIP_INSTALL := $(BIN)/python -m pip --disable-pip-version-check install --no-compile
# a step that takes a while shows that it is at work
WATCH := $(BIN)/python tools/watch.py
# stages of the virtual environment: what it2hys needs to run, it2hys itself, what tests and development need
RUNTIME := $(VENV)/.runtime
INSTALLED := $(VENV)/.installed
TOOLS := $(VENV)/.tools
CBUILD := build/c
DOCS_TOOLS := build/docs/tools
# what is compiled or copied on installation; the Python files are used where they are
COMPILED := $(shell find fmu_src scenarios -type f -not -path 'fmu_src/tests/*' -not -path 'fmu_src/fuzz/*' \
        -not -path 'fmu_src/bench/*' -not -path '*/__pycache__/*') \
        $(addprefix python/it2hys/,$(addprefix model/,variables.toml controller.toml variables.py ssv.py) \
        $(addprefix fmu/,codegen.py amalgamation.py cross_compiling.py))

.DEFAULT_GOAL := help

# where there is no C compiler: zig's from PyPI (the wheel's build backend sees to itself); for any processor,
# because valgrind knows not all that this one may have
ifeq ($(shell command -v cc || command -v gcc || command -v clang),)
WITH_CC := CC='"$(CURDIR)/$(BIN)/python" -m ziglang cc -mcpu=baseline'
endif

# what Python has compiled is kept for the many processes of the tests
unexport PYTHONDONTWRITEBYTECODE

# zig builds its own libraries once, for all that compiles here
export ZIG_GLOBAL_CACHE_DIR ?= $(CURDIR)/build/zig

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

.PHONY: help demo test lint ctest hardened pytest installation docs diagnosis design own-effects bench modelica clean install
help:
	@sed -n 's/^# make/make/p' $(firstword $(MAKEFILE_LIST))

install: $(INSTALLED)

$(VENV)/pyvenv.cfg:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "it2hys needs Python 3.11 or newer, which $(PYTHON) is not. Name another: make PYTHON=python3.12" >&2; exit 1; }
	@$(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); \
	  echo "$(PYTHON) cannot make a virtual environment. Debian and Ubuntu have that in the package python3-venv." >&2; \
	  exit 1; }

$(RUNTIME): requirements.lock $(VENV)/pyvenv.cfg
	@$(WATCH) "installing what it2hys needs to run" $(PIP_INSTALL) -r requirements.lock
	@touch $@

# Compilers and CMake come into an environment that pip removes afterwards, or are those of $(TOOLS).
$(INSTALLED): $(RUNTIME) pyproject.toml LICENSE $(COMPILED)
	@$(WATCH) "building it2hys for all platforms" \
	  $(PIP_INSTALL) -v --no-deps $$(test ! -e $(TOOLS) || echo --no-build-isolation) --editable .
	@touch $@

$(TOOLS): requirements-dev.lock $(RUNTIME)
	@$(WATCH) "installing what the tests need" $(PIP_INSTALL) -r requirements.lock -r requirements-dev.lock
	@touch $@

demo: $(INSTALLED)
	$(BIN)/it2hys run demo

# what leaves a core free runs beside others, the longest first
test: $(TOOLS)
	$(MAKE) --jobs 2 --output-sync installation lint ctest hardened docs
	$(MAKE) pytest

lint: $(TOOLS)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/clang-format --dry-run -Werror $$(find fmu_src -name "*.[ch]")

ctest: $(TOOLS)
	$(WITH_CC) $(BIN)/cmake -S fmu_src -B $(CBUILD) -G Ninja -DCMAKE_MAKE_PROGRAM="$(CURDIR)/$(BIN)/ninja" \
	  -DPython_EXECUTABLE="$(CURDIR)/$(BIN)/python"
	$(BIN)/cmake --build $(CBUILD)
	$(BIN)/ctest --test-dir $(CBUILD) --output-on-failure -j 2

hardened: ctest
	$(WITH_CC) PATH="$(CURDIR)/$(BIN):$$PATH" fmu_src/tests/hardened.sh "$(CURDIR)/$(CBUILD)" \
	  "$(CURDIR)/$(BIN)/python"

pytest: $(TOOLS) $(INSTALLED) $(if $(shell command -v mvn),$(VDMCHECK)/.fetched $(MAESTRO)/.fetched)
	# what is still installed for the tests, see .ci/run
	$(WAIT)
	# two workers are all the cores there may be: no threads besides
	# slipcover counts lines at 4 % of the time, where coverage takes half as much again on Python 3.11 (measured)
	# a file's tests stay together, for each worker makes anew what they share
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m slipcover --source python/it2hys \
	  --missing-width 40 -m pytest -n 2 --dist loadfile --no-loadscope-reorder

# once, and by itself: it builds and installs the package in all the ways that pip has
installation: $(TOOLS) $(INSTALLED)
	$(BIN)/python -m pytest -m installation tests/installation

# beside the tools of the tests, of which some want other versions of the same packages
$(DOCS_TOOLS)/.installed: requirements-docs.lock $(TOOLS)
	@$(WATCH) "installing what the documentation needs" \
	  $(PIP_INSTALL) --no-deps --upgrade --target $(@D) -r requirements-docs.lock
	@touch $@

docs: $(DOCS_TOOLS)/.installed $(INSTALLED)
	PYTHONPATH="$(CURDIR)/$(DOCS_TOOLS)" OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 \
	  $(BIN)/python -m sphinx -q -W --keep-going docs build/docs/html
	@echo "build/docs/html/index.html"

# figures go to benchmarks/diagnosis_history.jsonl; what was done before is not done again
diagnosis: $(INSTALLED) $(TOOLS)
	$(BIN)/python -m pytest -n 2 -m gate
	$(BIN)/python benchmarks/diagnosis.py $(if $(SEEDS),--seeds $(SEEDS)) $(if $(CASES),--cases '$(CASES)')

# loops go to build/designs/loops.jsonl; what was done before is not done again
design: $(INSTALLED)
	$(BIN)/python benchmarks/designs.py $(if $(SEEDS),--seeds $(SEEDS)) $(if $(COUNT),--count $(COUNT)) \
	  $(if $(PAIRS),--pairs '$(PAIRS)') $(if $(NOISE),--noise $(NOISE))

# outcomes are kept in build/own_effects; what was done before is not done again
own-effects: $(INSTALLED)
	$(BIN)/python benchmarks/own_effects.py $(if $(SEEDS),--seeds $(SEEDS)) $(if $(KIND),--kind '$(KIND)')

bench: $(INSTALLED) ctest
	$(BIN)/cmake -S fmu_src -B $(CBUILD) -DREFERENCE_FMUS="$(if $(REFERENCE_FMUS),$(abspath $(REFERENCE_FMUS)))"
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python benchmarks/bench.py --build $(CBUILD) $(if $(BEFORE),--before $(BEFORE))

# what OpenModelica says of it, where there is omc: python tests/modelica/omc_acceptance.py
modelica: $(INSTALLED)
	@mkdir -p dist
	$(BIN)/it2hys modelica dist/IT2Hysteresis-$$(sed -n 's/^version = "\(.*\)"/\1/p' pyproject.toml).zip

clean:
	rm -rf $(VENV) build dist out
