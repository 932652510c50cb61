"""What the documents show is true: commands run with the shipped data, and files are what they are said to be."""

import json
import re
import socket
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
import yaml
from click import Command

from controller.research.identification.tables import read_measured
from controller.schema.actuator import PRESETS, Actuator, read_actuator
from server.cli.main import app
from tests.docs.blocks import EXAMPLES, LONG, NOT_HERE, PAGES, SMALLER, Block, Shell, blocks, commands, name

SERVED = "127.0.0.1:8321", " ID "
"""What a command names that needs a server with a recording: test_served has its page."""
ALL = [command for page in PAGES for command in commands(page)]
HERE = [page for page in PAGES if not any(one in command for command in commands(page) for one in SERVED)]


def free_port() -> str:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return str(found.getsockname()[1])


@pytest.fixture
def shell(tmp_path: Path) -> Iterator[Shell]:
    places = {"0.0.0.0": "127.0.0.1", "RIG": "127.0.0.1", "7447": free_port(), "/etc/systemd/system": "."}
    found = Shell(tmp_path, places, TENDRIL_RECORDINGS=str(tmp_path / "recordings"))
    yield found
    found.close()


def test_every_block_says_what_it_is() -> None:
    kinds = {(name(page), block.kind) for page in PAGES for block in blocks(page)}
    assert [one for one in sorted(kinds) if one[1] not in {"sh", "python", "text", *WHOLE}] == []
    assert sum(page.read_text().count("\n```") for page in PAGES) == 2 * sum(len(blocks(page)) for page in PAGES)


def test_what_is_left_out_is_still_there_to_be_left_out() -> None:
    assert [command for command in (*NOT_HERE, *LONG, *SMALLER) if command not in ALL] == []
    assert all(NOT_HERE.values())


@pytest.mark.parametrize("page", [page for page in HERE if set(commands(page)) - NOT_HERE.keys() - LONG], ids=name)
def test_the_commands_of_a_page_run(page: Path, shell: Shell) -> None:
    for command in commands(page):
        if command not in NOT_HERE and command not in LONG:
            shell.run(command)


@pytest.mark.long
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("command", sorted(LONG))
def test_a_long_command_runs(command: str, shell: Shell) -> None:
    shell.run(command)


def actuator_or_part(text: str, file: Path) -> None:
    """A whole actuator file, or one of its tables."""
    if "mass" in tomllib.loads(text):
        file.write_text(text)
        read_actuator(str(file))
    else:
        Actuator.model_validate(PRESETS["P1"].model_dump() | tomllib.loads(text))


def table(text: str, file: Path) -> None:
    file.write_text(text)
    assert read_measured(file).columns


WHOLE: dict[str, Callable[[str, Path], Any]] = {
    "json": lambda text, file: json.loads(text),
    "yaml": lambda text, file: yaml.safe_load(text)["scrape_configs"],
    "toml": actuator_or_part,
    "csv": table,
}
FILES = [block for page in PAGES for block in blocks(page) if block.kind in WHOLE]


@pytest.mark.parametrize("block", FILES, ids=lambda block: f"{block.page.name} {block.kind}")
def test_a_file_that_is_shown_is_one(block: Block, tmp_path: Path) -> None:
    WHOLE[block.kind](block.text, tmp_path / f"shown.{block.kind}")


def known(command: Command, words: list[str]) -> list[str]:
    """Options among `words` that the command does not have; it may name a command of a group, or begin with one."""
    while words and (inner := getattr(command, "commands", {})) and not words[0].startswith("-"):
        names = [inner.get(one) for one in re.split(r"\\?\|", words.pop(0))]
        if None in names:
            return ["no such command"]
        command = names[0]
    options = {option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)}
    return [word for word in words if word.startswith("--") and word not in options | {"--help"}]


def test_every_command_that_a_text_names_is_there_with_its_options() -> None:
    tendril = typer.main.get_command(app)
    said = {found for page in PAGES for found in re.findall(r"`tendril ([^`]+)`", page.read_text())}
    assert len(said) > 40
    wrong = {text: lacking for text in said if (lacking := known(tendril, re.sub(r"[\[\]]", " ", text).split()))}
    assert wrong == {}


def test_the_shipped_data_are_what_the_program_beside_them_makes(shell: Shell) -> None:
    (shell.folder / "again").mkdir()
    shell.run("python make_data.py again")
    made = sorted((shell.folder / "again").iterdir())
    assert [file.name for file in made] == sorted(file.name for file in EXAMPLES.glob("*.csv"))
    for file in made:
        ours, theirs = (np.loadtxt(one, delimiter=",", skiprows=1) for one in (EXAMPLES / file.name, file))
        assert np.allclose(ours, theirs, rtol=0.0, atol=1e-4 if ours.max() < 10 else 2e-3), file.name
