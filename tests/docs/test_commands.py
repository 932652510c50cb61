"""What the documents show is true: commands run with the shipped data, and files are what they are said to be."""

import json
import re
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
import yaml
from click import Command

from controller.drivers.registry import capture_device, valve_device
from controller.research.identification.tables import read_measured
from controller.schema.actuator import PRESETS, Actuator, read_actuator
from controller.schema.rig_file import RigFile
from server.cli.main import app
from tests.docs.blocks import EXAMPLES, LONG, NOT_HERE, PAGES, SMALLER, Block, Shell, blocks, commands, free_port, name

SERVED = "127.0.0.1:8321", " ID "
"""What a command names that needs a server with a recording: test_served has its page."""
ALL = [command for page in PAGES for command in commands(page)]
LEFT_ALONE = {"text", "matlab", "py"}
"""No commands; `py` is a program that a test of its own runs."""
unchanged = pytest.mark.keyed("server/cli", "server/app", "docs")
HERE = [page for page in PAGES if not any(one in command for command in commands(page) for one in SERVED)]


@pytest.fixture
def shell(tmp_path: Path) -> Iterator[Shell]:
    places = {"0.0.0.0": "127.0.0.1", "RIG": "127.0.0.1", "7447": free_port(), "/etc/systemd/system": "."}
    places |= {f"docs/examples/{file.name}": file.name for file in EXAMPLES.glob("*.toml")}
    found = Shell(tmp_path, places, TENDRIL_RECORDINGS=str(tmp_path / "recordings"))
    yield found
    found.close()


def test_every_block_says_what_it_is() -> None:
    kinds = {(name(page), block.kind) for page in PAGES for block in blocks(page)}
    assert [one for one in sorted(kinds) if one[1] not in {"sh", "python", *LEFT_ALONE, *WHOLE}] == []
    assert sum(page.read_text().count("\n```") for page in PAGES) == 2 * sum(len(blocks(page)) for page in PAGES)


def test_what_is_left_out_is_still_there_to_be_left_out() -> None:
    assert [command for command in (*NOT_HERE, *LONG, *SMALLER) if command not in ALL] == []
    assert all(NOT_HERE.values())


@unchanged
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


def toml(text: str, file: Path) -> None:
    """Of an actuator or a rig: a whole file, or some of its tables; of a package, only that it can be read."""
    found = tomllib.loads(text)
    if "motion_capture" in found or "valves" in found:
        rig_or_part(found)
    elif "project" not in found:
        actuator_or_part(text, found, file)


def rig_or_part(found: dict[str, Any]) -> None:
    """With the options that its drivers take."""
    capture, valves = (
        found.get(table, {"driver": like}) for table, like in (("motion_capture", "natnet"), ("valves", "udp"))
    )
    whole = RigFile.model_validate(found | {"motion_capture": capture, "valves": valves})
    if "motion_capture" in found:
        capture_device(whole.motion_capture)
    valve_device(whole.valves)


def actuator_or_part(text: str, found: dict[str, Any], file: Path) -> None:
    if "mass" in found:
        file.write_text(text)
        read_actuator(str(file))
    else:
        Actuator.model_validate(PRESETS["P1"].model_dump() | found)


def table(text: str, file: Path) -> None:
    file.write_text(text)
    assert read_measured(file).columns


WHOLE: dict[str, Callable[[str, Path], Any]] = {
    "json": lambda text, file: json.loads(text),
    "yaml": lambda text, file: yaml.safe_load(text)["scrape_configs"],
    "toml": toml,
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


@unchanged
def test_the_shipped_data_are_what_the_program_beside_them_makes(shell: Shell) -> None:
    (shell.folder / "again").mkdir()
    shell.run("python make_data.py again")
    made = sorted((shell.folder / "again").iterdir())
    assert [file.name for file in made] == sorted(file.name for file in EXAMPLES.glob("*.csv"))
    for file in made:
        ours, theirs = (np.loadtxt(one, delimiter=",", skiprows=1) for one in (EXAMPLES / file.name, file))
        assert np.allclose(ours, theirs, rtol=0.0, atol=1e-4 if ours.max() < 10 else 2e-3), file.name
