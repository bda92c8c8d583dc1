# make demo    set up and run the main job: FRFs, a better posture, pictures and a page in demo/
# make test    set up and run the tests
# make docs    build the documentation as a site, in site/
# make tour    act a newcomer in an empty environment: README and tutorials to the letter; some minutes
# make distribution  wheel and sdist in clean environments, for each Python there is, and with the oldest dependencies
# make slow    run the tests that compute for two seconds and more, but those of a main job
# make check   ruff, mypy, import-linter, and what is in the wheel
# make tables  remake the tables in docs/
# make pictures  redraw the pictures of docs/optimisation.md and docs/machining.md; some minutes
# make live-pictures  take the pictures and the film of docs/live.md of the page itself
# make studies run the thesis's optimisations again, beside its printed numbers; some minutes
# make bench   measure engine, reading and fitting against their goals and peers; some minutes
# make exam    some 400 campaigns with effects hidden in them, for the diagnosis to name; goes on where it was stopped
# make arithmetic  the same verdicts on every processor: campaigns diagnosed under other kinds of arithmetic
# make appendix  diagnose the thesis's measured modes: docs/appendix_c.md with its pictures; some minutes
# make recovery  identify 300 simulated campaigns; goes on where it was stopped; half an hour
# make collisions  a hundred random tasks beside a table and a fixture; a quarter of an hour
# make fuzz    a million spoilt URDFs, cards, cuts, toolpaths, postures, arguments and campaigns; goes on where it was stopped
# make chaos   kill every command that writes at each of its file events; some minutes
# make accuracy  FRFs and modes of 500 random robots against sixty digits; half an hour
# make atlas-bench  an atlas of a million postures against the kernel alone; some minutes and 7 GB of disk
# make clean   remove what these made

PYTHON ?= python3.11
BIN := .venv/bin
# one more than there are processors: tests that start commands and browsers wait for them
WORKERS := $(shell echo $$(($$(getconf _NPROCESSORS_ONLN) + 1)))
# Bytecode is made as modules are first imported, by every processor there is; pip would make all of it with one.
PIP := $(BIN)/python -m pip install --quiet --no-compile --constraint constraints.txt
export PYTHONDONTWRITEBYTECODE =
.DEFAULT_GOAL := help
.PHONY: help demo test docs tour distribution slow check tables pictures live-pictures studies exam arithmetic appendix recovery bench fuzz chaos accuracy atlas-bench collisions browser clean

help:
	@grep '^# make' Makefile | cut -c3-

# Two stages, so that the demo does not wait for the tools of the tests.
.venv/installed: pyproject.toml constraints.txt
	@$(PYTHON) -m venv .venv || { echo "this Python has no venv module; on Debian: apt-get install python3.11-venv"; exit 1; }
	$(BIN)/python -m pip install --quiet --upgrade "pip>=25.1"
	$(PIP) --editable ".[arms]"
	@touch $@

.venv/tested: .venv/installed
	$(PIP) --group dev
	@touch $@

demo: .venv/installed
	$(BIN)/flexmodal demo --out demo --force

# Chromium is for the browser tests; without root and apt-get it has to be there already.
browser:
	@command -v chromium >/dev/null || { \
	  echo "installing chromium"; \
	  { [ "$$(id -u)" = 0 ] && S= || S=sudo; $$S apt-get update -qq && \
	    DEBIAN_FRONTEND=noninteractive $$S apt-get install -y -qq chromium fonts-dejavu-core >/dev/null; } || \
	  { echo "please install chromium; its tests need it"; exit 1; }; }

# A module's tests stay together, so that what they share is made once.
test: .venv/tested browser
	OPENBLAS_NUM_THREADS=1 $(BIN)/pytest -n $(WORKERS) --dist loadscope -q

slow: .venv/tested browser
	OPENBLAS_NUM_THREADS=1 $(BIN)/pytest -n auto --dist loadscope -q -m slow

check: .venv/tested
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy flexmodal viewer/flexmodal_viewer
	$(BIN)/lint-imports
	$(BIN)/python tests/distribution/wheel_contents.py

tables: .venv/tested
	$(BIN)/python benchmarks/fanuc_frequencies.py
	$(BIN)/python benchmarks/six_link_postures.py
	$(BIN)/python benchmarks/ema_methods.py
	$(BIN)/python benchmarks/ema_real.py
	$(BIN)/python benchmarks/ema_selection.py
	$(BIN)/python benchmarks/identification_thesis.py
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/stumbles.py

pictures: .venv/tested docs
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/optimisation_pictures.py
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/machining_checks.py
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/machining_posture.py
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/welcome_pictures.py
	$(BIN)/python benchmarks/site_pictures.py

live-pictures: .venv/tested browser
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/live_pictures.py

studies: .venv/tested
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/studies.py

FORM_SETS := looked sealed unseen later blind further third fourth fifth sixth seventh
# Some hours; what is answered already is not asked again. Sealed forms are simulated here and nowhere else.
exam: .venv/tested
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/exam.py
	for forms in $(FORM_SETS); do OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/exam.py --forms $$forms || exit 1; done
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/exam.py --engine mujoco

arithmetic: .venv/tested
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/arithmetic.py

appendix: .venv/tested
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/appendix_c.py

recovery: .venv/tested
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/identification_recovery.py
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/identification_routes.py
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/identification_speed.py
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/intervals.py --count 12

.venv/documented: .venv/installed
	$(PIP) --group docs
	@touch $@

# A warning is an error: a link to nowhere, a name that is not there.
docs: .venv/documented
	OPENBLAS_NUM_THREADS=1 NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo "site/index.html; with search: python -m http.server --directory site"

# In an environment of its own, outside the checkout.
tour: .venv/tested
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/tour.py

distribution: .venv/tested
	$(BIN)/python tests/distribution/clean_environment.py --sdist
	$(BIN)/python tests/distribution/clean_environment.py --lowest --python $(PYTHON)

clean:
	rm -rf .venv dist build demo exam site .pytest_cache .mypy_cache .ruff_cache

# INPUTS of all targets together, a million, some hours of one processor; goes on where it was stopped.
INPUTS ?= 1000000
fuzz: .venv/tested
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/fuzz.py --count $(INPUTS)

accuracy: .venv/tested
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/accuracy.py

atlas-bench: .venv/tested
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/atlas_bench.py

collisions: .venv/tested
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/collisions.py --starts 6

chaos: .venv/tested
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/chaos.py

.venv/peers: .venv/tested
	$(PIP) --group bench
	@touch $@

# One thread for everybody, or the ratios would compare core counts; sdynpy loads Qt, which wants no screen.
bench: .venv/peers
	OPENBLAS_NUM_THREADS=1 QT_QPA_PLATFORM=offscreen $(BIN)/python benchmarks/engine.py
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/engine_accuracy.py
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/engine_program.py
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/campaign_loading.py
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/ema_speed.py
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/ema_ripple.py
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/ema_peaks.py
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/ema_participation.py
