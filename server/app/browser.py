"""A headless chromium for the benchmark (the `bench` extra): the page as a real viewer loads it."""

import importlib.util
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from controller.errors import TendrilError
from controller.system.origin import install_command

if TYPE_CHECKING:
    from playwright.sync_api import Browser

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
"""The first is chromium without what lies around a page: a tab costs it half the processor time to open."""
FLAGS = ["--no-sandbox", "--disable-background-networking", "--disable-component-update", "--no-first-run"]


def find_chromium() -> str:
    """Path of the installed chromium; `TendrilError` without one."""
    for name in NAMES:
        if found := shutil.which(name):
            return found
    raise TendrilError(f"no browser found ({', '.join(NAMES)}); on Debian: apt-get install chromium")


def require_browser() -> None:
    """Raise TendrilError that says how to get what `launch_chromium` lacks."""
    if importlib.util.find_spec("playwright") is None:
        raise TendrilError(f"playwright is not installed: {install_command('bench')}")
    find_chromium()


@contextmanager
def launch_chromium() -> "Iterator[Browser]":
    """A running chromium, closed at the end."""
    require_browser()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=find_chromium(), args=FLAGS)
        try:
            yield browser
        finally:
            browser.close()
