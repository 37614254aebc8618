# Everything from a fresh checkout: `make demo` stretches a real sheet, `make test` runs the suite.
PYTHON ?= python3
VENV ?= .venv
BIN = $(VENV)/bin
# One thread each: the suite runs in two processes, and the default solver is sequential. Commands that tests start find
# the package compiled, which an environment may have switched off.
THREADS = OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 PYTHONDONTWRITEBYTECODE=

.PHONY: demo gallery test validate random-sheets crossings external packaging notebooks docs lint clean

demo: $(VENV)/ready
	$(BIN)/kirigami demo --folder demo

# Every example in its reduced form, with its pictures: well under an hour on two cores.
gallery: $(VENV)/installed
	$(BIN)/python tools/gallery.py gallery

# Neighbours stay in one process, where they share what fixtures made, until one of the two has nothing left to do.
test: $(VENV)/installed
	$(THREADS) MPLBACKEND=Agg $(BIN)/python -m pytest -n 2 --dist worksteal -m "not long and not external"

# The long validations: the published sheets in full, and everything that takes more than seconds.
validate: $(VENV)/installed
	$(THREADS) MPLBACKEND=Agg $(BIN)/python -m pytest -m long

# Random cut sheets with default settings, a thousand on bars and hinges and two hundred on shells: hours on two cores. Run
# again, it goes on where it was (tables: random_sheets_plate.csv, random_sheets_shell.csv).
random-sheets: $(VENV)/installed
	$(THREADS) MPLBACKEND=Agg $(BIN)/python benchmarks/random_sheets.py --table random_sheets_plate.csv
	$(THREADS) MPLBACKEND=Agg $(BIN)/python benchmarks/random_sheets.py --stiffness shell --seeds 200 --table random_sheets_shell.csv

# Whether anything crosses in a thousand random sheets with self-contact and 200 folded ones: some hours on one core.
MINUTES ?= 600
crossings: $(VENV)/installed
	$(THREADS) MPLBACKEND=Agg $(BIN)/python benchmarks/nothing_crosses.py --sheets 1000 --folded 200 --minutes $(MINUTES)

# Runs CalculiX, OpenSeesPy and a headless browser: Debian packages calculix-ccx and chromium.
external: $(VENV)/installed
	$(BIN)/python -m pip install --quiet openseespy pyvista build
	$(THREADS) MPLBACKEND=Agg $(BIN)/python -m pytest -m external

# Wheel and source distribution in fresh environments: no extra, each alone, and all Python versions that are here.
PYTHONS ?= $(PYTHON)
packaging:
	CHECK=extras tools/check_packaging.sh $(PYTHONS)

notebooks: $(VENV)/docs-installed
	$(BIN)/python tools/notebooks.py notebooks

docs: $(VENV)/docs-installed
	$(THREADS) $(BIN)/sphinx-build -W --keep-going -q docs docs/_build/html

lint: $(VENV)/installed
	$(BIN)/ruff check kirigami tests examples benchmarks tutorials tools
	$(BIN)/mypy kirigami

# What the demonstration needs; tests and tools need far more, which takes longer to fetch than the demonstration to run.
$(VENV)/ready: setup.cfg pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet -e ".[fast,io,viz]"
	touch $@

$(VENV)/installed: $(VENV)/ready
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet -e ".[dev]"
	touch $@

$(VENV)/docs-installed: $(VENV)/installed
	$(BIN)/python -m pip install --quiet -e ".[dev,docs]"
	touch $@

clean:
	rm -rf $(VENV) demo gallery build dist *.egg-info notebooks docs/_build docs/generated docs/tutorials docs/api.md docs/changelog.md docs/tutorials.md docs/gallery.md
