# Two commands do everything: `make demo` and `make test`. Both install what they need into .venv. `make cockpit` builds the page that
# `hydrocrane live` serves; it alone needs Node.js. `make evidence` runs the slower tests; `make drives`, `make fuzz` and `make soak` are
# the same tools at full size.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
CARGO  ?= cargo
# Everything that goes into the compiled module.
SOURCES := $(shell find crates machines scenarios -name '*.rs' -o -name '*.toml') Cargo.toml Cargo.lock pyproject.toml

# Tests start hundreds of programs. Where no bytecode is kept, each of them compiles all that it imports, for almost two seconds.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test compiled-and-tested module-of-tests test-rust test-python evidence evidence-python evidence-processes evidence-studies evidence-browser evidence-tools cockpit fmu controller drives machines-at-random environments fuzz soak bench docs site lint clean

demo: $(VENV)/.built
	$(BIN)/hydrocrane simulate vertical-lift-open-loop --output results

test: compiled-and-tested test-python

# Python's environment is made and fetched while cargo compiles the Rust tests. The module then waits for them and shares their crates:
# same profile, same features (tests/python/house/test_shared_crates.py). It is compiled while the Rust tests run, since much of it takes
# one core.
compiled-and-tested:
	$(CARGO) test --workspace --quiet & rust=$$!; $(MAKE) --no-print-directory $(VENV)/.tested || { kill $$rust; exit 1; }; wait $$rust

test-rust:
	$(CARGO) test --workspace --quiet

# Tests go to as many processes as there are cores, four at most; those of a file stay together, since they share fixtures. Files are
# taken in their order: those with few tests, put last otherwise, are often the longest, and one core would wait for them. OpenBLAS has
# one thread in each: with more, they wait for each other, and eigenvalues of a middling matrix take tens of times as long.
PYTEST := OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses logical --maxprocesses 4 --dist loadfile --no-loadscope-reorder
test-python: $(VENV)/.tested
	$(PYTEST) -m "not evidence"

# All other tests, and the tools in their short forms.
evidence: evidence-python evidence-tools

evidence-python: evidence-processes evidence-studies evidence-browser

evidence-processes: $(VENV)/.tested $(VENV)/.documented results/katex/node_modules/.package-lock.json
	$(PYTEST) -m "evidence and not browser and not study"

# Statistics over many seeds, which take minutes each and depend on little that changes.
evidence-studies: $(VENV)/.tested
	$(PYTEST) -m study

# The browser has the machine to itself: the page's clock is the wall's. The cockpit is tested where its page can be built and a
# browser can be had; elsewhere those tests are skipped.
evidence-browser: $(VENV)/.tested
	@$(MAKE) --no-print-directory cockpit || echo "the cockpit's page could not be built here: the tests that need it are skipped"
	@sh tests/browser.sh $(BIN)/python
	$(BIN)/python -m pytest -m browser

evidence-tools: $(VENV)/.tested
	$(BIN)/python tests/frozen/bits.py
	$(MAKE) --no-print-directory drives DRIVES=1 DRIVE_SECONDS=20 PAGE_OF=
	$(MAKE) --no-print-directory machines-at-random RANDOM_MACHINES=40 PAGE_OF=
	$(MAKE) --no-print-directory environments STEPS=1e6 PAGE_OF=
	$(MAKE) --no-print-directory fuzz INPUTS=2000 PAGE_OF=

# The cockpit's page, carried by every wheel that is built after it.
PAGE := python/hydrocrane/app/cockpit_page
COCKPIT := $(shell find cockpit -name node_modules -prune -o -name tests -prune -o -name '*.wasm' -prune -o -type f -print)

cockpit: $(PAGE)/index.html

# Half an hour of driving without a browser, and again in one where there is one: speed, memory, jumps.
MINUTES ?= 30
soak: cockpit $(VENV)/.tested
	node cockpit/tests/soak.mjs cockpit/src/core.wasm $(MINUTES)
	$(BIN)/python tests/python/soak_cockpit.py $(MINUTES)

# Random drives of every bundled machine in the native core and in the page's, judged; fails where something does not hold.
# A line of figures per case goes to RAW, the page to docs/validation. MACHINES, MODES and PAYLOADS, lists with commas, take a part of them;
# GROUND=yes lets the ground carry. Without a page's core, where none can be built, only the native one is driven.
DRIVES ?= 100
DRIVE_SECONDS ?= 60
SEED ?= 0
RAW ?= results/evidence
# Whether what was found is written into docs/validation.
PAGE_OF ?= yes
CASES = $(if $(MACHINES),--machines $(MACHINES)) $(if $(MODES),--modes $(MODES)) $(if $(PAYLOADS),--payloads $(PAYLOADS)) $(if $(GROUND),--ground $(GROUND))
TOOLS = $${CARGO_TARGET_DIR:-target}/release
RANDOM_DRIVES = $(TOOLS)/random-drives --drives $(DRIVES) --seconds $(DRIVE_SECONDS) --seed $(SEED) $(CASES)
drives: $(VENV)/.tested
	-@$(MAKE) --no-print-directory cockpit/src/core.wasm
	$(CARGO) build --quiet --release --package hydrocrane-evidence
	@mkdir -p $(RAW)
	$(RANDOM_DRIVES) --lowering yes --output $(RAW)/native.jsonl || [ $$? -eq 1 ]
	if [ -e cockpit/src/core.wasm ]; then $(RANDOM_DRIVES) --script cockpit/tests/random_drives.mjs --core cockpit/src/core.wasm --against $(RAW)/native.jsonl --output $(RAW)/page.jsonl || [ $$? -eq 1 ]; fi
	$(BIN)/python docs/validation/random_drives.py $(if $(PAGE_OF),--page) $(RAW)/native.jsonl $(RAW)/page.jsonl $(SEED)

# Random machines and circuits, judged; fails where something does not hold, or writes the page that lists it.
RANDOM_MACHINES ?=
machines-at-random: $(VENV)/.tested
	$(BIN)/python docs/validation/random_machines.py $(if $(RANDOM_MACHINES),--seeds $(SEED):$$(($(SEED) + $(RANDOM_MACHINES)))) $(if $(PAGE_OF),--page)

# Learning environments under the actions of a learner; fails where a step takes too long.
STEPS ?= 1e8
environments: $(VENV)/.tested
	$(BIN)/python docs/validation/environment_soak.py --steps $(STEPS) $(if $(PAGE_OF),,--no-page)

# Damaged machine and scenario files and links for the core, damaged study and mapping files and logs for Python; fails where
# one of them makes a panic, a hang, a large memory or a number that is none. What failed goes to FAILURES.
INPUTS ?= 100000
FAILURES ?= results/fuzz
fuzz: $(VENV)/.tested
	$(CARGO) build --quiet --release --package hydrocrane-evidence
	@mkdir -p $(FAILURES)
	$(TOOLS)/fuzz --inputs $(INPUTS) --seed $(SEED) --failures $(FAILURES) --output $(FAILURES)/core.jsonl || [ $$? -eq 1 ]
	$(BIN)/python tests/fuzz/fuzz_files.py --inputs $(INPUTS) --seed $(SEED) --failures $(FAILURES) --output $(FAILURES)/python.jsonl || [ $$? -eq 1 ]
	$(BIN)/python docs/validation/fuzzing.py $(if $(PAGE_OF),--page) $(FAILURES)/core.jsonl $(FAILURES)/python.jsonl

$(PAGE)/index.html: cockpit/node_modules/.package-lock.json cockpit/src/core.wasm cockpit/src/chains.wasm $(COCKPIT)
	cd cockpit && npm run --silent build
	@touch $@

# One core for chains as the bundled machines have them, and a larger one that the page loads for any other. Built together with the
# library that tests take, they would keep all their names, a fifth of their size.
CORE = RUSTFLAGS="$(REMAP) -C target-feature=+simd128 -C link-arg=--strip-all" $(CARGO) rustc --quiet --profile cockpit --target wasm32-unknown-unknown --package hydrocrane-web --crate-type cdylib
cockpit/src/core.wasm: $(SOURCES)
	-rustup target add wasm32-unknown-unknown
	$(CORE)
	cp $${CARGO_TARGET_DIR:-target}/wasm32-unknown-unknown/cockpit/hydrocrane_web.wasm $@

cockpit/src/chains.wasm: cockpit/src/core.wasm
	$(CORE) --features chains
	cp $${CARGO_TARGET_DIR:-target}/wasm32-unknown-unknown/cockpit/hydrocrane_web.wasm $@

cockpit/node_modules/.package-lock.json: cockpit/package.json cockpit/package-lock.json
	@command -v npm >/dev/null || { echo "the cockpit's page needs Node.js 20 or newer to be built: install it, then run make cockpit again"; exit 1; }
	cd cockpit && npm ci --silent
	@touch $@

# Everything in the documentation that is generated: validation pages and their figures, reference, front page, pictures.
docs: $(VENV)/.tested
	$(BIN)/python reproductions/heinze-2007/make.py
	$(BIN)/python docs/reference/states_and_outputs.py
	$(BIN)/python docs/reference/keys.py
	$(BIN)/hydrocrane control benchmark --output docs/validation/tip-control
	$(BIN)/python docs/validation/tip_motion.py
	$(BIN)/python docs/validation/tip_rest.py
	$(BIN)/python docs/validation/tip_further.py
	$(BIN)/python docs/validation/tip_control.py
	$(BIN)/python docs/validation/loading_cycle.py measure
	$(BIN)/python docs/validation/sensor_faults.py
	$(BIN)/python docs/validation/static_identification.py
	$(BIN)/python docs/validation/redundancy.py
	$(BIN)/python docs/validation/friction_lab.py
	$(BIN)/python docs/validation/dynamic_friction.py
	$(BIN)/python docs/validation/supply.py
	$(BIN)/python docs/validation/hysteresis.py
	$(BIN)/python docs/validation/rooms.py
	$(BIN)/python docs/reference/front_page.py
	$(BIN)/python docs/reference/sensitivities.py
	$(BIN)/python docs/pictures/make.py

# The site, to be read without a network: the Markdown files as they stand, with search and mathematics. It needs no compiled module;
# with one, the notebooks are run. `make cockpit site` puts the cockpit on the first page.
SITE := results/site
site: $(VENV)/.documented results/katex/node_modules/.package-lock.json
	$(BIN)/python -m sphinx -q --fail-on-warning --keep-going --jobs auto --builder html --conf-dir docs/site -d results/site-cache . $(SITE)
	@echo "the site: $(SITE)/index.html"

$(VENV)/.documented: $(BIN)/python pyproject.toml
	$(BIN)/python -m uv pip install --quiet --python $(BIN)/python --requirements pyproject.toml --extra docs
	@touch $@

results/katex/node_modules/.package-lock.json: docs/site/package.json docs/site/package-lock.json
	@command -v npm >/dev/null || { echo "the site's mathematics come from npm: install Node.js 20 or newer, then run make site again"; exit 1; }
	@mkdir -p results/katex
	cp docs/site/package.json docs/site/package-lock.json results/katex
	cd results/katex && npm ci --silent --ignore-scripts && mkdir -p static/fonts
	cd results/katex && cp node_modules/katex/dist/katex.min.css static && cp node_modules/katex/dist/fonts/*.woff2 static/fonts
	@touch $@

# All of docs/validation/speed.md; competitors that cannot be installed here are named as missing.
bench: $(VENV)/.tested $(VENV)/.built
	-$(BIN)/python -m pip install --quiet --editable '.[bench]'
	$(BIN)/python -m benches
	$(BIN)/python benches/sensitivities.py

# rustfmt and clippy come with most toolchains, but not with all.
lint: $(VENV)/.tested
	@if command -v cargo-clippy rustfmt >/dev/null; then \
		$(CARGO) fmt --check && $(CARGO) fmt --check --manifest-path benches/solvers/Cargo.toml && \
		$(CARGO) fmt --check --manifest-path crates/embedded/Cargo.toml && \
		$(CARGO) clippy --quiet --workspace --all-targets -- -D warnings && \
		$(CARGO) clippy --quiet --manifest-path crates/embedded/Cargo.toml -- -D warnings; \
	else echo "this toolchain lacks rustfmt or clippy: rustup component add rustfmt clippy"; fi
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

$(BIN)/python:
	$(PYTHON) -c 'import sys; sys.exit("hydrocrane needs Python 3.11 or newer, this is %d.%d; set PYTHON=" % sys.version_info[:2] if sys.version_info < (3, 11) else 0)'
	@command -v $(CARGO) >/dev/null || { echo "hydrocrane needs Rust: install the stable toolchain with rustup, then run make again"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	-$(BIN)/python -m pip install --quiet 'uv>=0.8,<1'

# uv fetches what the package needs in a sixth of pip's processor time; without it, pip does the same a line later.
FETCH = -$(BIN)/python -m uv pip install --quiet --python $(BIN)/python --requirements pyproject.toml --extra

# The library inside exported FMUs, for this platform, with its own profile; every wheel that is built after it carries it.
PLATFORM := $(shell echo "$$(uname -s | tr A-Z a-z)-$$(uname -m | sed s/arm64/aarch64/)")
LIBRARY := $(if $(findstring darwin,$(PLATFORM)),dylib,so)
FMU := python/hydrocrane/fmu_library/$(PLATFORM)
fmu_library = $(CARGO) rustc --quiet --package hydrocrane-fmi --profile $(1) -- -C strip=symbols && mkdir -p $(FMU) && \
	cp $${CARGO_TARGET_DIR:-target}/$(2)/libhydrocrane_fmu.$(LIBRARY) $(FMU)/hydrocrane_fmu.$(LIBRARY)

# What others get does not say where it was built: crates from elsewhere lie in cargo's own folder, and only they keep whole paths.
REMAP := --remap-path-prefix=$(or $(CARGO_HOME),$(HOME)/.cargo)=cargo
$(VENV)/.built fmu: export RUSTFLAGS = $(REMAP)

# The library alone: `make fmu` mends an installation that lacks it.
fmu: $(BIN)/python
	$(call fmu_library,release,release)

# The controllers as a static library for C programs, which needs no operating system: `make controller`, for who exports one. Tests
# take one for fewer joints.
CONTROLLER := python/hydrocrane/controller_library/$(PLATFORM)
controller_library = $(CARGO) build --quiet --release --locked --manifest-path crates/embedded/Cargo.toml $(1) && mkdir -p $(CONTROLLER) && \
	cp $${CARGO_TARGET_DIR:-crates/embedded/target}/release/libhydrocrane_controller.a $(CONTROLLER)

controller: $(VENV)/.controllers

$(VENV)/.controllers: $(BIN)/python $(SOURCES)
	$(call controller_library)
	@touch $@

# An editable installation: Python files are used in place, the compiled module is built anew when a source changes.
$(VENV)/.built: $(BIN)/python $(SOURCES)
	$(FETCH) parquet
	$(BIN)/python -m pip install --quiet --editable '.[parquet]'
	$(call fmu_library,release,release)
	@touch $@

# The module of `make demo` serves where it is up to date. Else one is built without link-time optimisation, of the crates that the
# Rust tests have compiled: the same bits.
# The controllers have a folder of compiled crates of their own, so they are compiled beside the rest.
$(VENV)/.tested: $(BIN)/python $(SOURCES)
	if ! $(MAKE) --question --no-print-directory $(VENV)/.controllers; then \
		$(call controller_library,--no-default-features --features joints-1 --features joints-3); fi & controllers=$$!; \
		$(MAKE) --no-print-directory module-of-tests || { kill $$controllers; exit 1; }; wait $$controllers
	@touch $@

module-of-tests:
	$(FETCH) test
	if ! $(MAKE) --question --no-print-directory $(VENV)/.built; then export MATURIN_PEP517_ARGS="--profile dev"; fi; \
		$(BIN)/python -m pip install --quiet --editable '.[test]'
	if ! $(MAKE) --question --no-print-directory $(VENV)/.built; then $(call fmu_library,dev,debug); fi

clean:
	rm -rf $(VENV) target crates/embedded/target results cockpit/node_modules cockpit/src/*.wasm $(PAGE) python/hydrocrane/fmu_library python/hydrocrane/controller_library
