# The two commands of the README. VENV and PYTHON may be set: make run PYTHON=python3.12
PYTHON ?= python3
VENV ?= .venv
OUT ?= out
BIN := $(VENV)/bin
JOBS ?= $(shell nproc 2>/dev/null || echo 1)

.PHONY: run test test-slow lint clean

$(VENV)/installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	@# torch first and by itself: a build made for this machine is kept where there is one
	$(BIN)/python -m pip install "torch>=2.13,<2.14"
	$(BIN)/python -m pip install -e ".[dev]"
	touch $@

run: $(VENV)/installed
	$(BIN)/vtbench run quick -o $(OUT)/quick --jobs $(JOBS)
	$(BIN)/vtbench board $(OUT)/quick -o $(OUT)/board

test: $(VENV)/installed
	$(BIN)/python -m pytest

test-slow: $(VENV)/installed
	$(BIN)/python -m pytest -m slow

lint: $(VENV)/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

clean:
	rm -rf $(OUT) build dist .pytest_cache .mypy_cache .ruff_cache
