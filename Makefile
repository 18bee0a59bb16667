# `make demo` flies the built-in scenario, `make test` runs all checks; both set up what they need. See README.md.
.PHONY: demo test lint bench clean set-up set-up-dev

SCENARIO = opnav-12h
FAULT = micas-stuck-on
# RUN: the run folder, for example `make demo RUN=runs/mine`. PYTHON: the interpreter for the virtual environment.
BIN = .venv/bin

demo: set-up
	@set -eu; run='$(RUN)'; \
	if [ -z "$$run" ]; then run="runs/demo-$$(date -u +%Y%m%dT%H%M%SZ)-$$$$"; fi; \
	status=0; $(BIN)/remote-agent run $(SCENARIO) --fault $(FAULT) --out "$$run" || status=$$?; \
	if [ ! -f "$$run/summary.json" ]; then exit $$status; fi; \
	printf '%s\n' '' "The run is in $$run: summary.json, report.html (for a browser), run.rrd (the recording)." \
	  'Look at the recording in the Rerun viewer, or as pictures where there is no display:' \
	  "  $(BIN)/remote-agent review \"$$run\"" \
	  "  $(BIN)/remote-agent review \"$$run\" --png \"$$run/pictures\""; \
	exit $$status

test: lint
	$(BIN)/python -m pytest

lint: set-up-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/codespell

bench: set-up
	$(BIN)/remote-agent bench

set-up:
	@PYTHON='$(PYTHON)' sh scripts/set_up run

set-up-dev:
	@PYTHON='$(PYTHON)' sh scripts/set_up dev

clean:
	rm -rf .venv build dist *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
