"""The package of docs/drivers.md as an installed one: its driver, and its far end."""

import re
from pathlib import Path
from typing import Any

from controller.system.origin import ROOT

PAGE = (ROOT / "docs" / "drivers.md").read_text()
DRIVER, PEER = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
POINTS = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)[0]


def made(source: str, name: str) -> Any:
    """What the page's `source` calls `name`."""
    names: dict[str, Any] = {"__name__": "labboard"}
    exec(compile(source, "labboard.py", "exec"), names)
    return names[name]


def install(folder: Path) -> None:
    """Into a folder that is, or will be, on the path."""
    package, about = folder / "labboard", folder / "labboard-1.0.dist-info"
    package.mkdir()
    about.mkdir()
    (package / "__init__.py").touch()
    (package / "driver.py").write_text(DRIVER)
    (package / "peer.py").write_text(PEER)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: labboard\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(entry_points(POINTS))


def entry_points(toml: str) -> str:
    """As pip writes them: [project.entry-points."group"] is [group], and no value is quoted."""
    groups = re.sub(r'\[project\.entry-points\."(.*)"\]', r"[\1]", toml)
    return re.sub(r'= "(.*)"', r"= \1", groups)
