# `make demo` and `make test` start from Python and make alone. VENV=, PYTHON= and ARGS= may be set on the command line.

VENV ?= .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.cadlink-installed
ARGS ?=

DEMO_OUT := out/square_cup
DEMO_RUN := $(BIN)/cadlink run examples/square_cup/aluminium.toml -o $(DEMO_OUT)
DEMO_PICTURE := $(BIN)/cadlink show $(DEMO_OUT) --png $(DEMO_OUT)/square_cup.png

.PHONY: help setup demo test validate lint clean

help:            ## this list
	@grep -E '^[a-z]+: .*##|^[a-z]+:  *##' $(MAKEFILE_LIST) | sed -E 's/^([a-z]+):[^#]*## (.*)/make \1\t\2/' | expand -t 16

setup: $(STAMP)  ## virtual environment with everything in it (also done by the targets below)

demo: $(STAMP)   ## draw the NUMISHEET'93 square cup and compare it with measurements
	$(DEMO_RUN)
	$(DEMO_PICTURE)

test: $(STAMP)   ## lint, format check and the quick tests
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/python -m pytest -q -n auto --dist loadfile $(ARGS)

validate: $(STAMP)  ## the slow tests: convergence studies and published numbers
	$(BIN)/python -m pytest -q -m slow $(ARGS)

lint: $(STAMP)   ## ruff and pyright
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright

clean:           ## remove results and caches; the virtual environment stays
	rm -rf out build dist .numba_cache .pytest_cache .ruff_cache .hypothesis .benchmarks
	find cadlink solver plugins examples tests -name __pycache__ -type d -prune -exec rm -rf {} +

# The system check comes first: before the virtual environment, and before half a gigabyte of wheels.
$(STAMP): pyproject.toml
	@python=$$(sh .ci/find_python) && $$python -I plugins/system_check.py && \
	    { $(BIN)/python -m pip --version >/dev/null 2>&1 || $$python -m venv --clear $(VENV); }
	@echo "installing cadlink and its dependencies into $(VENV): some minutes the first time"
	$(BIN)/python -m pip install --disable-pip-version-check --quiet --editable '.[cad,dev]'
	@echo "compiling the kernels: half a minute, once"
	$(BIN)/python -m plugins.compile_kernels examples/square_cup/aluminium.toml
	@touch $@
