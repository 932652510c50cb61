# Two commands: `make run` (twin + dashboard) and `make test`. Each does all its set-up.
PYTHON ?= python3
BIN := .venv/bin
NODE := PATH="$(CURDIR)/$(BIN):$$PATH"
# One more than there are cores: most tests wait for a third of their time. More would each bring a rig that ticks.
WORKERS := $(shell expr $$(nproc) + 1)
# After the set-up, for which the tests wait; but `nice` alone, 10, would leave it a twentieth of a busy machine.
ASIDE := nice -n 3
PAGE_SOURCES := $(shell find frontend -type f -not -path '*/node_modules/*' 2>/dev/null)
KERNEL_SOURCES := server/cli/kernels.py $(shell find controller server/drawing server/runs -name '*.py')
# Where the environment forbids bytecode, every process would compile all of its libraries again: 1 to 2 s each.
export PYTHONDONTWRITEBYTECODE =

.PHONY: run test check setup build chromium side-by-side quick lint types test-page lint-page types-page
.PHONY: test-python test-alone test-campaign test-quick test-browser test-long renew lock schema lines clean

run:
	$(MAKE) --no-print-directory -j2 setup
	$(BIN)/tendril up

# What can run side by side does; tests that keep time run alone.
test:
	$(PYTHON) .ci/parts.py side-by-side test-python test-alone test-campaign test-browser

side-by-side:
	$(MAKE) --no-print-directory -j3 --output-sync=target setup chromium test-page lint types

# For the minute between two edits: everything but tests that start processes or keep time.
check:
	$(PYTHON) .ci/parts.py quick

quick:
	$(MAKE) --no-print-directory -j4 --output-sync=target .venv/kernels test-page lint types test-quick

setup: .venv/installed frontend/node_modules/installed server/static/index.html .venv/kernels

.venv/kernels: .venv/installed $(KERNEL_SOURCES)
	$(BIN)/tendril compile
	touch $@

.venv/node: .ci/requirements.lock
	.ci/make-venv "$(PYTHON)"
	touch $@

.venv/installed: .venv/node pyproject.toml
	.ci/fill-venv
	touch $@

frontend/node_modules/installed: frontend/package-lock.json .venv/node
	cd frontend && $(NODE) npm ci --no-audit --no-fund --loglevel=error
	touch $@

server/static/index.html: frontend/node_modules/installed $(PAGE_SOURCES)
	cd frontend && $(NODE) npm run --silent build

build: server/static/index.html
	$(BIN)/python -m hatchling build -t wheel

chromium:
	.ci/need-chromium
	.ci/need-avr

lint: .venv/installed lint-page
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports

types: .venv/installed types-page
	$(ASIDE) $(BIN)/mypy
	$(NODE) .ci/same-schema

# What needs the page's libraries only is done while pip still works, for which everything else waits.
test-page: frontend/node_modules/installed
	cd frontend && $(NODE) $(ASIDE) npm test --silent

lint-page: frontend/node_modules/installed
	cd frontend && $(NODE) $(ASIDE) npm run --silent lint

types-page: frontend/node_modules/installed
	cd frontend && $(NODE) $(ASIDE) npm run --silent check

test-python: setup
	$(BIN)/python -m pytest tests --ignore tests/e2e -n $(WORKERS) --dist worksteal -m "not long and not alone and not campaign"

# What keeps time or kills processes (`alone`) runs apart from what takes all cores, no more at a time than there are
# cores: with three on two, a rig, its devices and its server were each kept waiting for longer than their limits.
test-alone: setup
	$(BIN)/python -m pytest tests --ignore tests/e2e -n 2 --dist worksteal -m "alone and not long"

test-campaign: setup
	$(BIN)/python -m pytest tests --ignore tests/e2e -m campaign

test-quick: .venv/kernels
	$(BIN)/python -m pytest tests --ignore tests/e2e -n $(WORKERS) --dist worksteal -m "not long and not alone and not campaign and not process"

# Each worker has a product of its own, and its pages; modules that need another one come after these.
test-browser: setup chromium
	$(BIN)/python -m pytest tests/e2e -n 2 --dist worksteal -m "not long and not alone"
	$(BIN)/python -m pytest tests/e2e -m "alone and not long"

test-long: setup chromium
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-build-isolation --editable '.[engines]' uv
	$(MAKE) --no-print-directory renew
	$(BIN)/python -m pytest tests -rP -m long

# Only what is skipped while its inputs stay the same (tests/keyed.py).
renew: setup chromium
	$(BIN)/python -m pytest tests --ignore tests/e2e -n $(WORKERS) --dist worksteal -m "keyed and not long and not alone and not campaign" --renew
	$(BIN)/python -m pytest tests --ignore tests/e2e -n 2 --dist worksteal -m "keyed and alone and not long" --renew
	$(BIN)/python -m pytest tests/server/campaign -m campaign --renew
	$(BIN)/python -m pytest tests/e2e -m "keyed and not long" --renew

# The page's types follow the server's OpenAPI; `make types` compares. Tables in docs/ follow the code that acts by them.
schema: .venv/installed frontend/node_modules/installed
	$(BIN)/tendril schema > .venv/openapi.json
	cd frontend && $(NODE) npm run --silent types -- ../.venv/openapi.json
	$(BIN)/python -m server.campaign.table
	$(BIN)/python -m controller.schema.safety_tables
	$(BIN)/python -m server.runs.phases
	$(BIN)/python -m server.app.tables

# Exact versions with hashes for every supported Python, without any registry address.
lock: .venv/installed
	$(BIN)/pip install --quiet uv
	$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --extra dev --generate-hashes --no-header \
	  --no-annotate --no-emit-index-url --no-emit-find-links --upgrade --output-file .ci/requirements.lock pyproject.toml

# Product lines: Python, TypeScript without generated types, CSS; no tests, no docs. The core is what no extra and no
# command of its own needs: without research, virtual rig, conformance of drivers and fault campaign.
PRODUCT = git ls-files 'controller/*.py' 'recordings/*.py' 'server/*.py' 'frontend/src/*.ts' 'frontend/src/*.tsx' \
  'frontend/src/*.css' | grep -vE '\.test\.tsx?$$|api/(schema\.d|bounds)\.ts$$'
EXTRAS := ^(controller/(research|virtual|drivers/conformance)|server/(campaign|cli/research))/
lines:
	@echo "product: $$($(PRODUCT) | xargs cat | wc -l)"
	@echo "core:    $$($(PRODUCT) | grep -vE '$(EXTRAS)' | xargs cat | wc -l)"

clean:
	rm -rf .venv frontend/node_modules server/static dist
