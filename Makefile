# Two commands: `make run` (twin + dashboard) and `make test`. Each does all its set-up.
PYTHON ?= python3
BIN := .venv/bin
NODE := PATH="$(CURDIR)/$(BIN):$$PATH"
PAGE_SOURCES := $(shell find frontend -type f -not -path '*/node_modules/*' 2>/dev/null)

.PHONY: run test setup kernels build chromium lint types test-page test-served test-timed test-computed test-campaign \
	test-long lock schema clean

run:
	$(MAKE) --no-print-directory -j2 setup
	$(BIN)/tendril up

# What can run side by side does. What only computes takes what the timed tests and the browser leave of the cores.
test:
	$(MAKE) --no-print-directory -j2 --output-sync=target setup chromium lint types test-page
	$(MAKE) --no-print-directory test-served
	$(MAKE) --no-print-directory -j2 --output-sync=target test-timed test-computed
	$(MAKE) --no-print-directory test-campaign
	@echo "make test: all passed"

setup: .venv/installed frontend/node_modules/installed server/static/index.html kernels

kernels: .venv/installed
	$(BIN)/tendril compile

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

lint: .venv/installed frontend/node_modules/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports
	cd frontend && $(NODE) npm run --silent lint

types: .venv/installed frontend/node_modules/installed
	$(BIN)/mypy
	cd frontend && $(NODE) npm run --silent check
	$(NODE) .ci/same-schema

test-page: frontend/node_modules/installed
	cd frontend && $(NODE) npm test --silent

PYTEST := $(BIN)/python -m pytest -m "not long"
COMPUTED := tests/controller $(patsubst %,tests/server/test_%.py,calibrate identify observe reproduce)
# These keep time or kill processes: they run apart from what takes all cores.
TIMED := $(patsubst %,tests/controller/test_%.py,clock link link_guarded loop pool rig ring supervisor) \
	$(patsubst %,tests/server/test_%.py,chain killed_rig live load logs runs shutdown) \
	$(patsubst %,tests/server/test_%.py,trouble two_machines viser) \
	$(patsubst %,tests/recordings/test_%.py,killed recorder)
CAMPAIGN := tests/server/test_campaign.py
# Runs only while nothing else wants the core.
IDLE := $(shell chrt --idle 0 true 2>/dev/null && echo chrt --idle 0 || echo nice -n 19)

test-served: setup
	$(PYTEST) tests --ignore tests/e2e $(patsubst %,--ignore %,$(COMPUTED) $(TIMED) $(CAMPAIGN)) -n auto --dist loadfile

test-computed: setup
	$(IDLE) $(PYTEST) $(COMPUTED) $(TIMED:%=--ignore %) -n auto --dist loadfile --timeout 1200

test-timed: setup chromium
	$(PYTEST) $(TIMED) -n 2 --dist loadfile
	$(PYTEST) tests/e2e -rP

test-campaign: setup
	$(PYTEST) $(CAMPAIGN)

test-long: setup chromium
	$(BIN)/python -m pytest tests -rP -m long

# The page's types follow the server's OpenAPI; `make types` compares. docs/safety.md follows the loop's tables.
schema: .venv/installed frontend/node_modules/installed
	$(BIN)/tendril schema > .venv/openapi.json
	cd frontend && $(NODE) npm run --silent types -- ../.venv/openapi.json
	$(BIN)/python -m server.faults.table
	$(BIN)/python -m controller.safety_tables

# Exact versions with hashes for every supported Python, without any registry address.
lock: .venv/installed
	$(BIN)/pip install --quiet uv
	$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --extra dev --generate-hashes --no-header \
	  --no-annotate --no-emit-index-url --no-emit-find-links --upgrade --output-file .ci/requirements.lock pyproject.toml

clean:
	rm -rf .venv frontend/node_modules server/static dist
