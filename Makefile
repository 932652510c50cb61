# Two commands: `make run` (twin + dashboard) and `make test`. Each does all its set-up.
PYTHON ?= python3
BIN := .venv/bin
NODE := PATH="$(CURDIR)/$(BIN):$$PATH"
PAGE_SOURCES := $(shell find frontend -type f -not -path '*/node_modules/*' 2>/dev/null)

.PHONY: run test setup build chromium lint types test-python test-page test-browser lock schema clean

run: setup
	$(BIN)/tendril up

test: setup chromium lint types test-page test-python test-browser
	@echo "make test: all passed"

setup: .venv/installed frontend/node_modules/installed server/static/index.html
	$(BIN)/tendril compile

.venv/installed: .ci/requirements.lock pyproject.toml
	.ci/make-venv "$(PYTHON)"
	touch $@

frontend/node_modules/installed: frontend/package-lock.json .venv/installed
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

# What keeps time or starts processes runs alone, the rest of the controller's tests on all cores.
ALONE := $(patsubst %,tests/controller/test_%.py,clock link loop pool rig ring supervisor)
test-python: setup
	$(BIN)/python -m pytest tests/controller $(ALONE:%=--ignore %) -n auto --dist loadfile
	$(BIN)/python -m pytest $(ALONE) tests/server tests/recordings tests/test_readme.py

test-browser: setup chromium
	$(BIN)/python -m pytest tests/e2e -rP

# The page's types follow the server's OpenAPI; `make types` compares.
schema: .venv/installed frontend/node_modules/installed
	$(BIN)/tendril schema > .venv/openapi.json
	cd frontend && $(NODE) npm run --silent types -- ../.venv/openapi.json

# Exact versions with hashes for every supported Python, without any registry address.
lock: .venv/installed
	$(BIN)/pip install --quiet uv
	$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --extra dev --generate-hashes --no-header \
	  --no-annotate --no-emit-index-url --no-emit-find-links --upgrade --output-file .ci/requirements.lock pyproject.toml

clean:
	rm -rf .venv frontend/node_modules server/static dist
