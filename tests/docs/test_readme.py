"""What the README promises about the code is checked against the code."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()
TABLE = set(re.findall(r"^\| (Eq\. \w+) \|.*\| `([\w/]+\.py):(\w+)` \|$", README, re.MULTILINE))


def homes() -> set[tuple[str, str, str]]:
    """Every equation mark in the kernels, with file and function."""
    found = set()
    for path in (ROOT / "controller" / "kernels").rglob("*.py"):
        source = path.read_text()
        lines = source.splitlines()
        for function in (node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.FunctionDef)):
            for line in lines[function.lineno - 1 : function.end_lineno]:
                if mark := re.search(r"# (Eq\. \w+)$", line):
                    found.add((mark[1], str(path.relative_to(ROOT)), function.name))
    return found


def test_the_table_names_every_equation_of_the_method() -> None:
    names = "KKT BAUM RAY S FF COND DEAD LAG OBS FDES UFB SAT HDOT".split()
    assert {name for name, _, _ in TABLE} == {f"Eq. {name}" for name in names}


def test_each_equation_is_computed_at_the_one_place_that_the_table_names() -> None:
    assert homes() == TABLE


PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_picture_and_document_that_is_linked_is_there(page: Path) -> None:
    links = re.findall(r"\]\((?!https?://)([^)#]+)\)", page.read_text())
    assert [link for link in links if not (page.parent / link).exists()] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_file_that_is_named_is_there(page: Path) -> None:
    named = re.findall(r"`((?:server|controller|recordings|frontend|tests)/[\w./-]+\.\w+)`", page.read_text())
    assert [name for name in named if not (ROOT / name).exists()] == []


def test_the_front_page_is_one_page() -> None:
    assert len(README.splitlines()) <= 120
