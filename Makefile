# `make help` lists what there is. Everything is set up in .venv, once, and again only when its sources change.

SHELL := bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
MAKEFLAGS += --no-builtin-rules

VENV := .venv
BIN := $(VENV)/bin
SECONDS_EACH ?= 600
RUST_SOURCES := $(shell find crates -name '*.rs' -o -name Cargo.toml -o -name README.md) Cargo.toml Cargo.lock

# pyo3 compiles against the environment's Python, whichever others are on the PATH.
export PYO3_PYTHON := $(CURDIR)/$(BIN)/python
export VIRTUAL_ENV := $(CURDIR)/$(VENV)
unexport PYTHONPATH PYTHONHOME

.PHONY: help
help: ## List the targets
	@sed -En 's/^([a-z-]+):.*## (.*)/  make \1|\2/p' $(MAKEFILE_LIST) | column -t -s '|'

.PHONY: demo
demo: $(VENV)/.built ## Draw a folded garment, fit it, show how well it went: demo/
	@$(BIN)/foldrs demo --out demo

.PHONY: test
test: test-rust test-python ## Run all tests, Rust and Python

.PHONY: test-rust
test-rust: $(VENV)/.tools
	cargo test --locked --quiet --package foldrs --all-features
	cargo test --locked --quiet --package foldrs --no-default-features
	cargo test --locked --quiet --package foldrs --no-default-features --features parallel --test api --test threads
	cargo test --locked --quiet --package foldrs --no-default-features --features serde --test api --test serde

.PHONY: test-python
test-python: $(VENV)/.built
	$(BIN)/python -m pytest

.PHONY: lint
lint: lint-rust lint-python ## Check format, style, types and licences

.PHONY: lint-rust
lint-rust: $(VENV)/.tools
	@for part in fmt clippy; do cargo $$part --version >/dev/null 2>&1 || \
	    { echo "cargo $$part is missing: rustup component add rustfmt clippy" >&2; exit 1; }; done
	cargo fmt --all --check
	cargo clippy --locked --quiet --workspace --all-targets --all-features -- -D warnings
	cargo clippy --locked --quiet --package foldrs --all-targets --no-default-features -- -D warnings

.PHONY: lint-python
lint-python: $(VENV)/.built
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/python -m mypy.stubtest foldrs._core
	bash .ci/types $(BIN)/python
	$(BIN)/python docs/list_licences.py --check
	bash .ci/version

.PHONY: docs
docs: $(VENV)/.built ## Build the documentation: site/index.html, site/rust/foldrs/index.html
	$(BIN)/python docs/draw_stages.py docs/stages/drawn
	$(BIN)/python docs/run_page.py docs/tutorial.md docs/tutorial
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs site
	RUSTDOCFLAGS="-D warnings" cargo doc --locked --quiet --no-deps --package foldrs --all-features
	rm -rf site/rust && cp -R "$${CARGO_TARGET_DIR:-target}/doc" site/rust

.PHONY: bench
bench: $(VENV)/.built ## Measure the speed of every step
	cargo bench --locked --package foldrs --all-features
	$(BIN)/python -m pytest benchmarks -o addopts="" --benchmark-only --benchmark-min-rounds=3 \
	    --benchmark-columns=median,iqr,rounds --benchmark-sort=name --quiet
	$(BIN)/python benchmarks/compare.py

.PHONY: crate
crate: ## Package the crate as it would be published, and build it from the package alone
	cargo package --locked --quiet --allow-dirty --package foldrs

.PHONY: fuzz
fuzz: ## Look for inputs that break a promise: SECONDS_EACH a target (needs cargo-fuzz and a C++ compiler)
	@cargo fuzz --version >/dev/null 2>&1 || { echo "cargo fuzz is missing: cargo install cargo-fuzz" >&2; exit 1; }
	@for target in outline fold inner_distance alignment template explain; do \
	    echo "== $$target"; mkdir -p target/fuzz/$$target; \
	    cargo fuzz run --sanitizer none $$target target/fuzz/$$target fuzz/corpus/$$target -- \
	        -max_total_time=$(SECONDS_EACH) -max_len=700 -timeout=20 -rss_limit_mb=1024; done

.PHONY: wheel
wheel: $(VENV)/.tools ## Build a wheel for every Python from 3.10 on: dist/
	rm -rf dist
	$(BIN)/maturin build --release --quiet --out dist
	@ls dist

.PHONY: sdist
sdist: $(VENV)/.tools ## Pack the sources as they would be published: dist/
	rm -f dist/*.tar.gz
	$(BIN)/maturin sdist --out dist
	@ls dist

.PHONY: picture
picture: demo ## Draw the pictures of README and docs: docs/images
	$(BIN)/python docs/draw_picture.py
	$(BIN)/python docs/draw_camera.py
	$(BIN)/python docs/draw_tutorial.py

.PHONY: picture-report
picture-report: $(VENV)/.built ## Draw the picture of the page of results: docs/images/report.webp (needs Chromium)
	$(BIN)/python docs/draw_report.py

.PHONY: licences
licences: $(VENV)/.built ## List the licences of all dependencies: docs/licences.md
	$(BIN)/python docs/list_licences.py > docs/licences.md

.PHONY: lock
lock: ## Pin the newest versions of all tools: requirements-dev.lock, requirements-rerun.lock (needs uv)
	uv pip compile pyproject.toml --extra dev --extra docs --universal --python-version 3.10 --upgrade \
	    --no-emit-index-url --custom-compile-command "make lock" --quiet --output-file requirements-dev.lock
	uv pip compile pyproject.toml --extra rerun --universal --python-version 3.10 --upgrade --no-annotate \
	    --constraints requirements-dev.lock --no-emit-index-url --custom-compile-command "make lock" --quiet \
	    --output-file requirements-rerun.lock

.PHONY: clean
clean: ## Remove all that was made here
	rm -rf $(VENV) target site dist demo docs/stages/drawn docs/tutorial

# Set-up. Each stamp is newer than what it was made from.

$(VENV)/.built: $(VENV)/.tools $(RUST_SOURCES) pyproject.toml
	@echo "Compiling foldrs (the first time takes a few minutes)"
	@$(BIN)/maturin develop --release --quiet
	@touch $@

$(VENV)/.tools: requirements-dev.lock
	@bash .ci/prerequisites "$(PYTHON)" $(VENV)
	@echo "Installing the tools of requirements-dev.lock into $(VENV)"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --requirement $<
	@touch $@
