"""Soon."""

from typing import Any


def page(*_: Any) -> str:
    """Soon."""
    return "<!doctype html><title>Commissioning</title>"
