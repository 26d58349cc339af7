# One command a job; `make help` lists them. Nothing but Python >= 3.11, a Rust toolchain and the package
# registries is needed: every Python tool lives in a virtual environment of its own, $(VENV).
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
MAKEFLAGS += --no-builtin-rules --no-print-directory

# The first Python on the path that is new enough.
PYTHON ?= $(shell for p in python3 python3.14 python3.13 python3.12 python3.11 python; do \
	$$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && { command -v $$p; break; }; done)
VENV ?= .venv-test
BIN := $(VENV)/bin
# One process a core: most tests wait for one thread of the core.
PYTEST := $(BIN)/python -m pytest -n auto --dist worksteal --doctest-modules --pyargs python/tests iridesce
PYTEST_ARGS ?=
CARGO_ARGS ?= --locked

READERS := .readers

# $(call beside,A,B): makes A, and B meanwhile, whose words come afterwards. Python's tools (packages, types), the largest crates
# and their link-time optimisation take one core each for minutes.
define beside
@told=$$(mktemp); $(MAKE) $(2) >"$$told" 2>&1 & other=$$!; \
trap 'kill $$other' INT TERM; failed=0; \
$(MAKE) $(1) || failed=1; \
wait $$other || failed=1; \
cat "$$told"; rm -f "$$told"; exit $$failed
endef

.PHONY: help fuzz reference readers board test-readers test quick lint lint-rust lint-python test-rust test-python build \
	test-both pytest web test-web docs bench wheel wheel-check images clean

help: ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-12s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

test: ## everything: lint, build, the tests of both languages, the code blocks of the docs
	@SECONDS=0; \
	$(MAKE) lint; \
	$(MAKE) test-both; \
	echo "make test: lint, Rust tests and Python tests all passed in $$SECONDS s"; \
	echo "make test: left out: the page and its core in wasm (make test-web; it takes Node 20 and the wasm target)"

quick: build ## the tests of both languages without the ones marked slow
	cargo test --workspace $(CARGO_ARGS)
	$(PYTEST) -m "not slow" $(PYTEST_ARGS)

lint: ## rustfmt, clippy, ruff, mypy; warnings are errors
	$(call beside,lint-rust,lint-python)

lint-rust:
	cargo fmt --all --check
	cargo clippy --workspace --all-targets $(CARGO_ARGS) -- -D warnings

lint-python: $(VENV)/tools
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

# The programs that read what `iridesce export` writes. Blender's module pins an old numpy: it has an environment of its own.
# Beside these: node with npm, chromium, glslangValidator (Debian: nodejs npm chromium glslang-tools).
readers: $(VENV)/tools ## install the programs that the tests of exports are read by, into .readers and the test environment
	$(BIN)/python -c 'import tomllib; d = tomllib.load(open("pyproject.toml", "rb")); \
		print(*d["project"]["optional-dependencies"]["readers"], sep="\n")' > $(VENV)/readers.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r $(VENV)/readers.txt
	mkdir -p $(READERS)
	npm install --silent --no-audit --no-fund --prefix $(READERS) gltf-validator@2.0.0-dev.3.10 three@0.187 playwright-core @babylonjs/core@9.35
	test -x $(READERS)/bpy/bin/python || $(PYTHON) -m venv $(READERS)/bpy
	$(READERS)/bpy/bin/python -m pip install --quiet --disable-pip-version-check bpy==5.0.1
	test -x $(READERS)/lux/bin/python || $(PYTHON) -m venv $(READERS)/lux
	$(READERS)/lux/bin/python -m pip install --quiet --disable-pip-version-check pyluxcore==2.11.2

board: build readers ## how far other renderers are from the charts: runs them all, reference/board.json and its page
	$(BIN)/python tools/data/exchange_board.py

test-readers: build readers ## the tests of exports with every reader required
	IRIDESCE_REQUIRE_READERS=1 $(BIN)/python -m pytest python/tests/exchange $(PYTEST_ARGS)

test-rust:
	cargo test --workspace $(CARGO_ARGS)

# While one of them waits for a long unit of code or a long test, the other has both cores.
test-both:
	$(call beside,test-python,test-rust)

test-python: build
	$(MAKE) pytest

pytest:
	$(PYTEST) $(PYTEST_ARGS)

# The page: Node 20 with npm, and rustup for the target that browsers run. Paths of this machine stay out of the module.
WASM := target/wasm32-unknown-unknown/web/iridesce_web.wasm
CRATES := $(or $(CARGO_HOME),$(HOME)/.cargo)/registry/src
WASM_FLAGS = -C target-feature=+simd128 --remap-path-prefix=$(HOME)/.rustup=rustup --remap-path-prefix=$(CURDIR)=. \
	$(foreach folder,$(wildcard $(CRATES)/*),--remap-path-prefix=$(folder)=crates)

web: web/node_modules ## build the page: web/dist/ for any static host, web/dist/iridesce.html from disk, the notebook widget
	command -v rustup >/dev/null && rustup target add wasm32-unknown-unknown || true
	RUSTFLAGS="$(WASM_FLAGS)" cargo build $(CARGO_ARGS) --profile web --target wasm32-unknown-unknown -p iridesce-web
	cd web && npx tsc --noEmit && node tools/build.mjs && node tools/build-widget.mjs dist/widget

web/node_modules: web/package-lock.json
	cd web && npm ci --no-audit --no-fund
	@touch $@

test-web: web ## the page: its core in Node against the native core, then all of it in Chromium (LINKS=10000 for more links)
	cd web && node --test tests/core/*.test.mjs && node --test --test-concurrency=1 tests/page/*.test.mjs

docs: build ## the documentation site in docs/_build/html, with the live page; warnings are errors
	$(BIN)/python -c 'import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]["docs"], sep="\n")' > $(VENV)/docs.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r $(VENV)/docs.txt
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs docs/_build/html

# The library says nothing of where it was built: panics of packages name `cargo/registry/...`. (Elsewhere: RUSTFLAGS of your own.)
NO_HOME = $(RUSTFLAGS) --remap-path-prefix=$(or $(CARGO_HOME),$(HOME)/.cargo)=cargo \
	--remap-path-prefix=$(or $(RUSTUP_HOME),$(HOME)/.rustup)=rustup --remap-path-prefix=$(CURDIR)=.

# The package is installed as a user installs it (a wheel, not an editable link), so that the tests also ask whether
# everything needed is inside. No build isolation: maturin is in the environment already, which saves a download a run.
build: $(VENV)/tools ## build the package and install it into the test environment
	RUSTFLAGS="$(NO_HOME)" PATH="$(abspath $(BIN)):$$PATH" $(BIN)/python -m pip install --quiet --no-build-isolation --no-deps --force-reinstall .

$(VENV)/tools: pyproject.toml
	@test -n "$(PYTHON)" || { echo "make: no Python >= 3.11 found; set PYTHON=/path/to/python" >&2; exit 1; }
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -c 'import tomllib; d = tomllib.load(open("pyproject.toml", "rb")); p = d["project"]; \
		print(*d["build-system"]["requires"], *p["dependencies"], *p["optional-dependencies"]["test"], sep="\n")' > $(VENV)/requirements.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --upgrade -r $(VENV)/requirements.txt
	@touch $@

# READER=NAME for one of them (`python tools/fuzz --list`), N for how many inputs each.
READER ?=
N ?= 10000
fuzz: ## mutate seeds of every reader, in processes with limits on memory and time; READER=x N=100000 for one
	$(BIN)/python tools/fuzz $(READER) -n $(N)

bench: build ## the measurements of docs/evidence/performance.md, on this machine
	$(BIN)/python bench/run.py

reference: build ## the reference suite: charts and scenes with spectral truth, in reference/
	$(BIN)/python tools/data/reference_suite.py

wheel: $(VENV)/tools ## a wheel for this platform in dist/
	RUSTFLAGS="$(NO_HOME)" $(BIN)/maturin build --release --locked --out dist

wheel-check: wheel ## install that wheel into a clean environment, without Rust in reach, and ask it for numbers
	$(BIN)/python tools/release/check_wheel.py dist

images: build ## the computed pictures of the docs, and the tables of docs/evidence/published-charts.md
	$(BIN)/python tools/pictures/doc_images.py
	$(BIN)/python tools/pictures/published_charts.py

clean: ## remove what the other targets made
	rm -rf target dist $(VENV) .mypy_cache .ruff_cache .pytest_cache
