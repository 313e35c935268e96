# Every target sets up what it needs; `make help` lists them. ARGS="..." goes to what a target runs.

# .venv, or .venv-jazzy where that is sourced: a shell with ROS and one without have an environment each
export VENV := .venv$(addprefix -,$(ROS_DISTRO))
PYTHON := $(VENV)/bin/python
# settings of a user for pip that have no meaning in an environment
export PIP_USER := 0
unexport PIP_TARGET PIP_PREFIX PIP_ROOT
# stands for the environment and holds the folder it was made in: an environment cannot be moved
READY := $(VENV)/.ready
COMPILED := $(VENV)/.compiled
INSTALLED_FROM := $(wildcard src/*/setup.py requirements*.txt) constraints.txt constraints-oldest.txt tools/setup.sh
CORE := $(shell find src/collplan_core -name '*.py')
# of the worlds serpentine:0 to 11 the one in the middle by the time that bounce saved in a trial, when it was chosen
SERPENTINE := serpentine:2
# two processes, each with a ROS domain of its own, one of them for whole graphs: tests/conftest.py
PYTEST = $(PYTHON) -m pytest -n 2 --dist loadfile

ifeq ($(ROS_DISTRO),)
# ROS from wheels: the environment is the ROS installation
export AMENT_PREFIX_PATH := $(CURDIR)/$(VENV)
unexport RMW_IMPLEMENTATION
endif

ifneq ($(shell cat $(READY) 2>/dev/null),$(CURDIR))
.PHONY: $(READY)
endif

.PHONY: help setup run demo study study-bounce results optimum graph-gain worth movers site-runs animation examples frozen messages test test-oldest test-processors soak faults faults-long bench lint format site dist ws

help:  ## this list
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## */  make \1\t/' | expand -t 24

setup: $(COMPILED)  ## make .venv, or .venv-jazzy where ROS is sourced, and compile the planner

run: $(COMPILED)  ## simulate a run to the goal, ARGS="--help" for its options
	@$(VENV)/bin/bringup $(ARGS)

demo: $(COMPILED)  ## watch the robot bounce through a serpentine, in a browser on this machine; simulated, Ctrl-C ends it
	@$(VENV)/bin/bringup --world $(SERPENTINE) --strategy bounce --view --again --no-pictures --out runs/demo $(ARGS)

study: $(COMPILED)  ## the paper's 300 runs and what they say, simulated, ARGS="--help" for its options
	@$(VENV)/bin/study $(ARGS)

study-bounce: $(COMPILED)  ## do deliberate bounces pay: every strategy in worlds nothing was tuned on, simulated
	@$(VENV)/bin/study --bounces $(ARGS)

results: $(COMPILED)  ## the studies behind docs/results.md, what is missing of them, hours; ARGS="table_1" for a part
	@$(PYTHON) studies/results.py $(ARGS)

optimum:  ## how far bounce and avoid are from the best without contact and with the map, simulated; needs CasADi
	@studies/optimum.sh $(ARGS)

site-runs: $(COMPILED)  ## the recorded runs that docs/runs.md plays anew, simulated
	@SERPENTINE=$(SERPENTINE) tools/site_runs.sh

animation: $(READY)  ## the README's animation anew, from docs/runs/serpentine.html; needs Chromium
	@$(PYTHON) tools/page_animation.py docs/runs/serpentine.html docs/avoid_beside_bounce.webp

frozen: export PYTHONPATH = $(CURDIR)/tests/frozen:$(CURDIR)/tests/runs:$(CURDIR)/tests/study
frozen: $(COMPILED)  ## take over a meant change of results, and say in words what has changed: tests/frozen
	@$(PYTHON) -m renew

examples: $(COMPILED)  ## the scripts of examples/ and their pictures in docs/pictures/examples, simulated
	@$(VENV)/bin/bringup --world slalom --strategy low_risk --no-pictures --out runs/examples
	@cd docs/pictures/examples && for script in $(filter-out %/stopping_way.py,$(wildcard $(CURDIR)/examples/*.py)); do \
		MPLBACKEND=agg $(CURDIR)/$(PYTHON) "$$script" $(CURDIR)/runs/examples/latest || exit 1; done
	@cd docs/pictures/examples && MPLBACKEND=agg $(CURDIR)/$(PYTHON) $(CURDIR)/examples/stopping_way.py

messages: $(READY)  ## the message packages of tests/messages, which pip lacks, for tests; needs cmake and a C++ compiler
	@tools/messages.sh

test: $(COMPILED) messages  ## all tests but the long ones
	@$(PYTEST) $(ARGS)

test-oldest:  ## what an older version may lack, on the oldest versions declared, in .venv-oldest
	@tools/test_oldest.sh $(ARGS)

test-processors: $(COMPILED)  ## core, simulator and what is frozen with other processors' last bits; ARGS="tests/sim" for a part
	@tools/processors.sh $(ARGS)

soak: $(COMPILED) messages  ## all tests with the long ones, then the core without its compiler: half an hour
	@failed=0; $(PYTEST) -m "soak or not soak" $(ARGS) || failed=1; \
		NUMBA_DISABLE_JIT=1 $(PYTEST) tests/core $(ARGS) || failed=1; exit $$failed

faults faults-long: export PYTHONPATH = $(CURDIR)/tools:$(CURDIR)/tests:$(CURDIR)/tests/sim:$(CURDIR)/tests/foreign
faults: $(COMPILED) messages  ## every fault 20 times to a robot that drives, simulated; docs/reliability.md anew
	@$(PYTHON) -m faults $(ARGS)

faults-long: $(COMPILED) messages  ## as often as each fault needs, hours; ARGS="--minutes 30" for a slice, the next call goes on
	@$(PYTHON) -m faults --long $(ARGS)

bench: export OPENBLAS_NUM_THREADS = 1
bench: $(COMPILED)  ## speed, side by side with 1.0.0, another planner and a simulator
	$(PYTHON) benchmarks/run.py $(ARGS)

graph-gain: $(COMPILED)  ## what of a bounce's gain is left through the graph; ARGS="--real-time", "--worlds 2 --seeds 1"
	@$(PYTHON) studies/graph_gain.py $(ARGS)

worth: $(COMPILED)  ## does it pay to bounce on my robot, from its parameters; ARGS="--params mine.yaml"
	@$(PYTHON) studies/worth.py $(ARGS)

movers: export OPENBLAS_NUM_THREADS = 1
movers: $(COMPILED)  ## what the strategies do where something moves, simulated; ARGS="--trials 200 --seed N"; the next call goes on
	@$(PYTHON) studies/movers_bench.py $(ARGS)

lint: $(READY)  ## style, types, and whether the code is heavier than tools/weight.toml allows
	@failed=0; for check in "-m ruff check" "-m ruff format --check" "-m mypy" tools/weight.py; do \
		echo "$$check"; $(PYTHON) $$check || failed=1; done; exit $$failed

format: $(READY)  ## lay the sources out as lint wants them
	$(PYTHON) -m ruff check --fix
	$(PYTHON) -m ruff format

site:  ## these pages and the interface as a web site in build/site; a link that leads nowhere fails it
	@tools/site.sh

dist: $(COMPILED)  ## the packages as wheels in dist/, installed and tried in a clean environment, without and with ROS
	@tools/dist.sh

ws: $(COMPILED)  ## build ros_ws with colcon and try its executables
	@tools/build_ws.sh $(ARGS)

$(READY): $(INSTALLED_FROM)
	@tools/setup.sh

# once, here: several nodes that start at the same time would each compile
$(COMPILED): $(READY) $(CORE)
	@echo "Compiling the planner ..."
	@$(PYTHON) -m collplan_core.warm_up
	@touch $@
