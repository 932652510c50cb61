"""Where figures come from is said whole, and codes are named as the loop knows them."""

import os
import re
from pathlib import Path

import pytest

from controller.schema.messages import Telemetry
from controller.schema.modes import Cause, Law, Mode
from controller.schema.origin import CODES, Origin, comment_lines, hashes, origin, origin_of_rig
from controller.schema.parameters import RigParameters
from controller.simulation.metrics import UNITS
from recordings.format.messages import Metrics

DOCS = Path(__file__).parents[3] / "docs"
DEFINED = re.compile(r"^\| ((?:`\w+`(?:, )?)+) \|", re.MULTILINE)


def test_every_code_of_telemetry_has_the_names_that_the_loop_acts_by() -> None:
    assert set(CODES) <= set(Telemetry.model_fields)
    for name, words in (("mode", Mode), ("cause", Cause), ("request_cause", Cause), ("law", Law)):
        assert CODES[name] == {word.name: word.value for word in words}
    assert [CODES["sensed"][f"rod_{rod}"] for rod in (1, 6, 10)] == [1, 32, 512]


def test_an_origin_is_read_back_as_it_was_written_and_stands_before_a_table_line_by_line() -> None:
    made = origin_of_rig(RigParameters(), "tendril track 'a\nb'", files={"a.csv": "0" * 64})
    assert Origin.model_validate_json(made.model_dump_json()) == made
    lines = comment_lines(made).splitlines()
    assert all(line.startswith("# ") for line in lines) and len(lines) == len(Origin.model_fields)
    assert comment_lines(None) == ""


def test_hardware_has_no_plant_and_no_seed() -> None:
    made = origin_of_rig(RigParameters(), simulated=False)
    assert made.plant is None and made.seeds == () and made.controller is not None
    assert origin().actuators == ()


def test_a_pipe_is_not_read_for_its_hash(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "file").write_text("abc")
    assert hashes([tmp_path / "pipe", tmp_path / "file"]) == {
        "file": "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    }


@pytest.mark.parametrize("figure", sorted({*UNITS, *Metrics.model_fields, "off_path_seconds", "branch_changes"}))
def test_every_figure_is_defined_once(figure: str) -> None:
    tables = {path.name: DEFINED.findall(path.read_text()) for path in DOCS.glob("*.md")}
    defined = [name for name, rows in tables.items() for row in rows if f"`{figure}`" in row]
    assert defined == ["measures.md"]
