# make         set up, then the whole pipeline on config/config.yaml, up to results/report.html
# make setup   set up only: .venv from requirements.lock; targets below add requirements-dev.lock
# make test    set up, then all tests
# make studies set up, then the tests of studies/
# make check   set up, then all tests, those of the next four targets too
# make browser set up, then pages in Chromium (Debian: apt-get install chromium)
# make slicer  set up, then slice plates of released objects (Debian: apt-get install prusa-slicer)
# make slurm   set up, then run on a Slurm cluster of one node (root; Debian: slurm-wlm, munge)
# make vision  set up, then the tests of networks (pip install safetensors torch)
# make bounds  set up, then the tests of compiled code with every index checked
# make bench   set up, then the benchmarks
# make docs    set up, then the documentation site in build/site (open build/site/index.html)
# make wheel   set up, then a wheel in build/dist, tried in an empty environment
# make leaderboard  set up, then verify leaderboard/ and write build/leaderboard/index.html
# make lint    set up, then all checks of the code that need no run
# make lock    add to the lock files what is new in pyproject.toml (newest of all: delete them first)

CORES ?= 2
# Two processes run the tests; the one that finishes first takes tests from the other. The limit of 900
# seconds cannot end a test that hangs in compiled code: then its process ends after 1000 seconds and
# prints where the test was, and the tests that waited for this process are not run.
TESTS := pytest --numprocesses 2 --dist worksteal --max-worker-restart 0 \
	-o faulthandler_timeout=1000 -o faulthandler_exit_on_timeout=true
VENV := .venv
READY := $(VENV)/.ready
TOOLS := $(VENV)/.tools-ready
DOCS := $(VENV)/.docs-ready
# 3.11 first, for which every package has a wheel
PYTHON ?= $(firstword $(foreach name,python3.11 python3.12 python3.13 python3 python,$(shell \
	$(name) -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))' \
	>/dev/null 2>&1 && echo $(name))))
export PATH := $(CURDIR)/$(VENV)/bin:$(PATH)

# For every platform but Windows and every Python from 3.11 on
COMPILE := build/lock/bin/uv pip compile --quiet --universal --python-version 3.11 \
	--fork-strategy fewest --generate-hashes --custom-compile-command "make lock"

.PHONY: all setup tools kernels test studies check bounds browser slicer slurm vision bench docs wheel leaderboard lint lock
.PHONY: has-chromium has-slicer has-slurm has-torch

all: setup
	snakemake --cores $(CORES)

setup: $(READY)

tools: $(TOOLS)

test: kernels
	$(TESTS)

studies: kernels
	$(TESTS) studies

# Compiled with few optimisations, which takes less time than these would save.
bounds: tools
	NUMBA_BOUNDSCHECK=1 NUMBA_OPT=1 $(TESTS)

check: kernels has-chromium has-slicer has-slurm has-torch
	$(TESTS) -m 'not slow and not wheel'

# Once, before processes of the tests would each do it.
kernels: tools
	python -m egad_workflow.precompile

browser: has-chromium
	pytest -m browser tests/report

slicer: has-slicer
	pytest -m slicer tests/evalset

slurm: has-slurm
	pytest -m slurm tests/workflow

vision: has-torch
	pytest tests/learning tests/detectors tests/bench/test_run_trials.py tests/bench/test_run_benchmark.py

has-chromium: tools
	@command -v chromium >/dev/null || { echo "chromium is needed" >&2; exit 1; }

has-slicer: tools
	@command -v prusa-slicer >/dev/null || { echo "prusa-slicer is needed" >&2; exit 1; }

has-slurm: tools
	@cd tests/workflow && python -c 'import slurm_node; raise SystemExit(slurm_node.why_not() or 0)'

has-torch: tools
	@python -c 'import safetensors, torch' || { echo "safetensors and torch are needed" >&2; exit 1; }

bench: tools
	pytest tests/benchmarks --capture=no --override-ini python_files='bench_*.py'

docs: $(DOCS)
	mkdocs build --strict

wheel: tools
	pytest -m wheel tests/test_wheel.py

# SAMPLE=5 simulates 5 objects, or rounds, of each table, not all
leaderboard: setup
	python -m egad_workflow.leaderboard --jobs $(CORES) $(if $(SAMPLE),--sample $(SAMPLE))

lint: tools
	ruff check
	ruff format --check
	mypy
	snakefmt --check Snakefile workflow studies/scenes studies/training
	snakemake --lint
	python docs/manual/manual.py --check

lock:
	$(PYTHON) -m venv build/lock
	build/lock/bin/pip install --quiet --require-hashes --requirement envs/installer.lock
	sed -n 's/^requires = \["\(.*\)"\]$$/\1/p' pyproject.toml \
		| $(COMPILE) --extra cluster --output-file requirements.lock pyproject.toml -
	$(COMPILE) --extra dev --constraint requirements.lock \
		$$(sed -n 's/^\([a-z0-9.-]*\)==.*/--no-emit-package \1/p' requirements.lock) \
		--output-file requirements-dev.lock pyproject.toml
	# what users have on some platforms only is there too
	$(COMPILE) --extra docs --constraint requirements.lock --constraint requirements-dev.lock \
		$$(sed -n 's/^\([a-z0-9.-]*\)==[^;]*$$$$/--no-emit-package \1/p' requirements.lock) \
		--output-file requirements-docs.lock pyproject.toml
	echo uv | $(COMPILE) --no-annotate --output-file envs/installer.lock -

$(READY): requirements.lock pyproject.toml envs/install.py envs/trim.py envs/compile.py
	@test -n "$(PYTHON)" || { echo "Python 3.11 or newer with venv and pip is needed" \
		"(Debian: apt-get install python3 python3-venv)" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(VENV)/bin/python envs/install.py requirements.lock --project .
	$(VENV)/bin/python envs/trim.py
	$(VENV)/bin/python envs/compile.py
	touch $@

$(TOOLS): $(READY) requirements-dev.lock
	$(VENV)/bin/python envs/install.py requirements-dev.lock
	touch $@

# after the tools, of which ruff lays out signatures
$(DOCS): $(TOOLS) requirements-docs.lock
	$(VENV)/bin/python envs/install.py requirements-docs.lock
	touch $@
