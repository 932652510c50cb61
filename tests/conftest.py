"""What holds for all tests: their marks are true, and what passed with the same inputs is not run again."""

import gc
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests import processes
from tests.keyed import Keyed

STARTING = {"shared_rig", "shell", "built"}
"""Fixtures that start processes, which serve several tests."""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--renew", action="store_true", help="run keyed tests too, and keep the inputs of those that pass")


def pytest_configure(config: pytest.Config) -> None:
    processes.watch()
    whole = not any("::" in str(one) for one in config.args) and not config.getoption("keyword")
    if config.option.markexpr != "long":  # those are run whole, changed or not
        config.pluginmanager.register(Keyed(config.getoption("--renew"), whole))


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Modules of which the marks that are asked for take nothing need not be imported: that takes seconds."""
    asked = config.option.markexpr
    if not collection_path.match("test_*.py"):
        return None
    text = collection_path.read_text()
    whole = re.findall(r"^pytestmark = pytest\.mark\.(\w+)$", text, re.MULTILINE)
    left_out = any(f"not {mark}" in asked for mark in whole)
    nothing = any(
        asked.startswith(mark) and f"mark.{mark}" not in text for mark in ("alone", "campaign", "keyed", "long")
    )
    return True if left_out or nothing else None


def pytest_itemcollected(item: pytest.Item) -> None:
    if STARTING & set(getattr(item, "fixturenames", ())) or "e2e" in item.path.parts:
        item.add_marker(pytest.mark.process)


def pytest_collection_finish() -> None:
    """Thousands of tests and all modules stay to the end: what looks for garbage need not look at them each time."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol() -> Iterator[None]:
    processes.started.clear()
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item) -> Iterator[None]:
    done = yield
    if processes.started and not any(map(item.get_closest_marker, ("process", "alone", "campaign", "long"))):
        pytest.fail(f"it starts a process and is not marked so: {processes.started}")
    return done
