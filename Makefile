# Two commands do all: `make demo` and `make test`. Both set up .venv first; a second call is quick.
SHELL := /bin/bash
.SHELLFLAGS := -e -o pipefail -c
PYTHON ?= python3
BIN := .venv/bin
STAMP := .venv/.installed

# Tests start many processes: what they import is compiled once, whatever the surroundings say.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test lint types layers size check soak bench system clean

demo: $(STAMP) ## make the demonstration book, ingest it, write its report
	@if [ -f demo-book/book/reports/demo/report.html ]; then \
	  echo "the demonstration is there already: demo-book/book/reports/demo/report.html (remove demo-book to make it anew)"; \
	else rm -rf demo-book && $(BIN)/labbook demo demo-book; fi

test: $(STAMP) system lint layers ## lint, layers, then types and all tests side by side
	@$(BIN)/mypy > .venv/types.txt 2>&1 & types=$$!; \
	echo "== tests, and types beside them"; failed=; \
	$(BIN)/python -m pytest -n 2 --dist worksteal -q -m "not soak" tests || failed=tests; \
	echo "== types"; wait $$types || failed="$$failed types"; cat .venv/types.txt; \
	if [ "$$failed" ]; then echo "failed: $$failed"; exit 1; fi

check: lint types layers size

lint: $(STAMP)
	@echo "== lint"
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check --quiet .

types: $(STAMP)
	@echo "== types"
	@$(BIN)/mypy

layers: $(STAMP)
	@echo "== layers"
	@$(BIN)/lint-imports --no-cache | tail -n 1

size: $(STAMP) ## lines, tokens, files and circles of imports, by package
	@$(BIN)/python scripts/house_size.py

soak: $(STAMP) ## the longer tests
	@$(BIN)/python -m pytest -n 2 --dist worksteal -q -m "soak or hypothesis" --hypothesis-profile=many tests

bench: $(STAMP) ## measure against the budgets, write docs/performance.md
	@$(BIN)/python benchmarks/run.py

system: ## what tests use beside Python: installed where that is wanted and allowed, else said
	@bash scripts/system_packages.sh

$(STAMP): pyproject.toml constraints.txt
	@echo "== setting up .venv"
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "labbook needs Python 3.11 or newer: make PYTHON=python3.11")'
	@$(PYTHON) -m venv .venv
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev,export,postgres,sweeps,web]'
	@touch $(STAMP)

clean:
	rm -rf .venv demo-book build dist
