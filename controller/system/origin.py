"""Where a program came from: its version, and the commit, as far as that is known."""

import shlex
import subprocess
import sys
from functools import cache
from importlib.metadata import requires, version
from importlib.resources import files
from pathlib import Path

NAME = "tendril-softrobotics"
"""Of the distribution; "tendril" is someone else's on the package index."""
ROOT = Path(__file__).parents[2]
KEPT = "static/commit"
"""Where a wheel keeps the commit that it was built from, in the package `server`."""


def version_text() -> str:
    """As "tendril 0.1.0 (commit 1a2b3c4, changed)"."""
    known = commit()
    return f"tendril {our_version()}" + (f" (commit {known})" if known else "")


def our_version() -> str:
    """As it stands in pyproject.toml when this was installed."""
    return version(NAME)


def command_line() -> str:
    """What was typed, to be typed again."""
    return shlex.join(["tendril", *sys.argv[1:]])


def install_command(extra: str) -> str:
    """What adds the packages of `extra` to this very installation, whether it is a clone or a wheel."""
    wanted = [text.split(";")[0].strip() for text in requires(NAME) or () if f"extra == '{extra}'" in text]
    return shlex.join([sys.executable, "-m", "pip", "install", *wanted])


@cache
def commit() -> str:
    """The commit of this source tree, marked if anything in it was changed since, or of this wheel; "" if unknown."""
    return _of_tree() if (ROOT / "pyproject.toml").exists() else _of_wheel()


def _of_tree() -> str:
    try:
        found = subprocess.run(
            ["git", "-C", ROOT, "describe", "--always", "--dirty=, changed", "--exclude=*"],
            capture_output=True,
            text=True,
            timeout=5.0,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return found.stdout.strip()


def _of_wheel() -> str:
    try:
        return files("server").joinpath(KEPT).read_text().strip()
    except OSError:
        return ""
