# Set-up in two commands: `make demo`, `make test`. Each makes its own virtual environment first.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
RUST := Cargo.toml Cargo.lock pyproject.toml $(shell find rust -name '*.rs')
export CARGO_INCREMENTAL ?= 0
FUZZ ?= 1000000

.DEFAULT_GOAL := help
FUZZ_S ?= 300
HOST = $(shell rustc -vV | sed -n 's/^host: //p')
# Which edges were taken, and what was compared with what: what guides libFuzzer.
SANCOV = -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
	-Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares

KEYPOINTS := .venv-keypoints

.PHONY: help demo reproduce test rust-tests test-keypoints acceptance fuzz fuzz-core faults lint lint-rust lint-python format bench bench-peers doc clean

help: ## Show this list
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 14

# The package with its development tools, built in release mode; again when Rust changes.
$(VENV)/.installed: $(RUST)
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install -q --disable-pip-version-check -e '.[dev]'
	@# pip does this for all but what is editable, and not every environment lets Python do it itself.
	$(BIN)/python -m compileall -q pytracker
	touch $@

demo: $(VENV)/.installed ## Simulate a recording, track it by every method, write report/index.html
	$(BIN)/pytracker demo --out report --force

reproduce: $(VENV)/.installed ## Run both papers' tables and figures again, into reproduced/
	$(BIN)/pytracker reproduce tao-hu --out reproduced/tao-hu
	$(BIN)/pytracker reproduce li-kulic --out reproduced/li-kulic

test: ## Run every test, Rust and Python
	@# What is linked as a whole keeps one core busy: beside it the tests are built.
	$(MAKE) -j 2 $(VENV)/.installed rust-tests
	cargo test --locked
	$(BIN)/python -m pytest -n 2 --dist worksteal

rust-tests:
	cargo test --locked --no-run

test-keypoints: ## The detector's own tests, in an environment of its own: MediaPipe wants NumPy 1
	test -x $(KEYPOINTS)/bin/python || $(PYTHON) -m venv $(KEYPOINTS)
	$(KEYPOINTS)/bin/python -m pip install -q --disable-pip-version-check '.[keypoints]' pytest pytest-xdist hypothesis
	cd tests && ../$(KEYPOINTS)/bin/python -m pytest -n 2 --dist worksteal test_detector.py

acceptance: $(VENV)/.installed ## The same with every seed, failing where the shared data is absent
	PYTRACKER_ACCEPTANCE=1 $(BIN)/python -m pytest -n 2 --dist worksteal

fuzz: $(VENV)/.installed ## Mutated files and absurd calls by the million (FUZZ=1000000): only our own errors
	$(BIN)/python tests/fuzz.py $(FUZZ)

fuzz-core: ## The core's arm tracker, guided by coverage (libFuzzer), for FUZZ_S seconds
	mkdir -p target/fuzz-corpus
	cd tests/fuzz && RUSTFLAGS="$(SANCOV) --cfg fuzzing" cargo build --release --locked --target-dir ../../target/fuzz --target $(HOST)
	target/fuzz/$(HOST)/release/tracker target/fuzz-corpus -max_total_time=$(FUZZ_S) -max_len=2048 -timeout=5 -rss_limit_mb=1024

faults: $(VENV)/.installed ## One thing wrong at a time: what is told, what is harmless, what is silent, into docs/faults.md
	$(BIN)/python tests/faults.py docs/faults.md

lint: lint-rust lint-python ## Formatting, clippy, ruff, mypy, stubtest, documentation
	@# The site has what cargo doc made.
	$(BIN)/python -W error -m mkdocs build --strict --quiet

lint-rust:
	cargo fmt --check
	cargo clippy --locked --all-targets --features python -- -D warnings
	RUSTDOCFLAGS='-D warnings' cargo doc --locked --no-deps --quiet

lint-python: $(VENV)/.installed
	$(BIN)/ruff format --check
	$(BIN)/ruff check
	$(BIN)/mypy
	$(BIN)/python -m mypy.stubtest pytracker._core

format: $(VENV)/.installed ## Format everything
	cargo fmt
	$(BIN)/ruff format
	$(BIN)/ruff check --fix

bench: ## Time the Rust core (criterion); needs no Python
	cargo bench --locked

bench-peers: $(VENV)/.installed ## Time against a NumPy twin, alternating in one process
	$(BIN)/python tests/bench_peers.py

doc: $(VENV)/.installed ## README, guide, examples and the API of both sides as one site, into target/site
	cargo doc --locked --no-deps
	$(BIN)/python -m mkdocs build --strict --quiet

clean: ## Remove everything that was made
	rm -rf target $(VENV) $(KEYPOINTS) report reproduced
