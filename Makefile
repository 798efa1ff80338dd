# Two commands do everything: `make demo` and `make test`. Both install what they need into .venv.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
CARGO  ?= cargo
# Everything that goes into the compiled module.
SOURCES := $(shell find crates machines scenarios -name '*.rs' -o -name '*.toml') Cargo.toml Cargo.lock pyproject.toml

.PHONY: demo test test-rust test-python bench docs lint clean

demo: $(VENV)/.built
	$(BIN)/hydrocrane simulate vertical-lift-open-loop --output results

test: test-rust test-python

test-rust:
	$(CARGO) test --workspace --exclude hydrocrane-python --quiet

test-python: $(VENV)/.tested
	$(BIN)/python -m pytest

# Everything in the documentation that is generated: validation pages and their figures, reference, front page, pictures.
docs: $(VENV)/.tested
	$(BIN)/python reproductions/heinze-2007/make.py
	$(BIN)/python docs/reference/states_and_outputs.py
	$(BIN)/hydrocrane control benchmark --output docs/validation/tip-control
	$(BIN)/python docs/validation/tuned_machines.py
	$(BIN)/python docs/validation/tip_control.py
	$(BIN)/python docs/validation/sensor_faults.py
	$(BIN)/python docs/validation/static_identification.py
	$(BIN)/python docs/validation/redundancy.py
	$(BIN)/python docs/validation/friction_lab.py
	$(BIN)/python docs/validation/dynamic_friction.py
	$(BIN)/python docs/reference/front_page.py
	$(BIN)/python docs/reference/sensitivities.py
	$(BIN)/python docs/pictures/make.py

# All of docs/validation/speed.md; competitors that cannot be installed here are named as missing.
bench: $(VENV)/.tested
	-$(BIN)/python -m pip install --quiet --editable '.[bench]'
	$(BIN)/python -m benches
	$(BIN)/python benches/sensitivities.py

lint: $(VENV)/.tested
	$(CARGO) fmt --check
	$(CARGO) fmt --check --manifest-path benches/solvers/Cargo.toml
	$(CARGO) clippy --workspace --all-targets -- -D warnings
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

$(BIN)/python:
	$(PYTHON) -c 'import sys; sys.exit("hydrocrane needs Python 3.11 or newer, this is %d.%d; set PYTHON=" % sys.version_info[:2] if sys.version_info < (3, 11) else 0)'
	@command -v $(CARGO) >/dev/null || { echo "hydrocrane needs Rust: install the stable toolchain with rustup, then run make again"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip

# An editable installation: Python files are used in place, the compiled module is built anew when a source changes.
$(VENV)/.built: $(BIN)/python $(SOURCES)
	$(BIN)/python -m pip install --quiet --editable '.[parquet]'
	@touch $@

$(VENV)/.tested: $(BIN)/python $(SOURCES)
	$(BIN)/python -m pip install --quiet --editable '.[test]'
	@touch $(VENV)/.built $@

clean:
	rm -rf $(VENV) target results
