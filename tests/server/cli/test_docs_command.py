"""`tendril docs`: what messages and help cite can be opened wherever Tendril runs."""

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
import typer
from typer.testing import CliRunner

from controller.system.origin import ROOT
from server.cli.docs import documents, heading
from server.cli.main import app

CITED = re.compile(r"tendril docs ([\w-]+)")
SOURCES = [
    path
    for folder, kinds in (("controller", "*.py"), ("server", "*.py"), ("recordings", "*.py"), ("frontend/src", "*.ts*"))
    for path in sorted((ROOT / folder).rglob(kinds))
]


def helps(command: click.Command, name: str = "tendril") -> Iterator[tuple[str, str]]:
    """Every text of help, with the command that says it."""
    yield name, command.help or ""
    for parameter in command.params:
        yield f"{name} {parameter.name}", getattr(parameter, "help", None) or ""
    for one, inner in getattr(command, "commands", {}).items():
        yield from helps(inner, f"{name} {one}")


def test_every_document_that_is_cited_is_there() -> None:
    cited = {(path.name, name) for path in SOURCES for name in CITED.findall(path.read_text())}
    assert {name for _, name in cited} >= {"actuators", "tables", "faults"}
    assert [one for one in sorted(cited) if one[1] not in documents()] == []


def test_help_cites_by_the_command_that_opens_it_and_by_no_path_of_the_sources() -> None:
    texts = list(helps(typer.main.get_command(app)))
    assert len(texts) > 100
    assert [name for name, text in texts if re.search(r"docs/|README", text)] == []


@pytest.mark.parametrize("name", sorted(documents()))
def test_a_document_is_read(name: str) -> None:
    said = CliRunner().invoke(app, ["docs", name])
    assert said.exit_code == 0
    assert heading(documents()[name]).replace("`", "") in said.output


def test_documents_are_listed_by_name_and_found_by_path() -> None:
    listed = CliRunner().invoke(app, ["docs"]).output.splitlines()
    assert [line.split()[0] for line in listed] == sorted(
        [*(path.stem for path in (ROOT / "docs").glob("*.md")), "examples"]
    )
    at = CliRunner().invoke(app, ["docs", "tables", "--path"]).output.strip()
    assert Path(at).samefile(ROOT / "docs" / "tables.md")


def test_the_examples_lie_beside_their_document() -> None:
    at = Path(CliRunner().invoke(app, ["docs", "examples", "--path"]).output.strip())
    assert {"poses.csv", "decays.csv", "spiral.csv", "client.py"} <= {file.name for file in at.parent.iterdir()}
    wheel = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert wheel["force-include"]["docs"] == "server/docs", "a package has the whole folder"


def test_an_unknown_document_is_refused_with_the_names_that_there_are() -> None:
    said = CliRunner().invoke(app, ["docs", "tabels"])
    assert said.exit_code == 2
    assert "'tabels' is none of actuators," in said.output
