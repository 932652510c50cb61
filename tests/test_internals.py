"""What a library does not promise to keep is named in one file of ours, and its version has an upper bound."""

import ast
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DEPENDENCIES = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
INTERNAL = {
    "numba": (r"llvmlite\b|numba\.(core|np|typed)\b", "controller/numba_internals.py"),
    "rerun-sdk": (r"rerun_bindings\b|rerun_cli\b", "recordings/format/tool.py"),
    "uvicorn": (r"uvicorn\.(_\w+|protocols)\b", "server/http/connections.py"),
}


@pytest.mark.parametrize("library", INTERNAL)
def test_internals_of_a_library_are_named_in_one_file(library: str) -> None:
    pattern, home = INTERNAL[library]
    users = {str(path.relative_to(ROOT)) for path in sources() if any(re.match(pattern, one) for one in imports(path))}
    assert users == {home}


def test_one_line_asks_viser_for_what_it_does_not_offer() -> None:
    lines = [line for path in sources() for line in path.read_text().splitlines() if "_websock_server" in line]
    assert len(lines) == 1


@pytest.mark.parametrize("library", [*INTERNAL, "viser", "eclipse-zenoh"])
def test_a_library_of_which_internals_are_used_has_an_upper_bound(library: str) -> None:
    (bound,) = [text for text in DEPENDENCIES if re.match(rf"{library}(\[\w+\])?[<>=]", text)]
    assert "<" in bound or "==" in bound


def sources() -> Iterator[Path]:
    for package in ("controller", "recordings", "server"):
        yield from (ROOT / package).rglob("*.py")


def imports(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
